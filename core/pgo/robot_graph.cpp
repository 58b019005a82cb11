// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/robot_graph.h"

#include <cmath>
#include <utility>

#include "core/pgo/hash.h"

namespace covey::pgo {
namespace {

// Beyond any measure: a single such value would drown the team's cost, which all members take from each other.
constexpr double kFarthestM = 1e6;
constexpr double kLargestPrecision = 1e15;

bool is_pose(const SE3& T) {
  return T.translation.cwiseAbs().maxCoeff() < kFarthestM && T.translation.allFinite() &&
         T.rotation.quaternion().coeffs().allFinite();
}

bool is_covariance(const Matrix6d& covariance) {
  if (!covariance.allFinite() || !(covariance.diagonal().array() > 0.0).all()) return false;
  const Precision precision = precision_of(covariance);
  return precision.kappa < kLargestPrecision && precision.tau < kLargestPrecision;
}

bool is_gravity(const Gravity& gravity) {
  if (gravity.sigma == 0.0) return true;
  return gravity.sigma > 0.0 && std::abs(gravity.down_K.norm() - 1.0) < 0.01;
}

// Of what was measured, whatever it counts as.
std::uint64_t key_of(const Loop& loop) {
  Hash hash;
  for (const KeyframeName& name : {loop.a, loop.b}) {
    hash.add(static_cast<std::uint64_t>(name.robot));
    hash.add(static_cast<std::uint64_t>(name.segment));
    hash.add(static_cast<std::uint64_t>(name.id));
  }
  const Eigen::Quaterniond q = loop.T_A_B.rotation.canonical_quaternion();
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) hash.add(value);
  for (const double value : loop.T_A_B.translation) hash.add(value);
  const Precision precision = precision_of(loop.covariance);
  hash.add(precision.kappa);
  hash.add(precision.tau);
  return hash.value();
}

}  // namespace

int GraphSnapshot::poses() const {
  std::size_t n = 0;
  for (const Segment& segment : segments) n += segment.poses.size();
  return static_cast<int>(n);
}

int GraphSnapshot::loops() const {
  std::size_t n = private_loops.size();
  for (const auto& [peer, loops] : shared_loops) n += loops.size();
  return static_cast<int>(n);
}

const char* RobotGraph::add(const Keyframe& keyframe) {
  if (keyframe.name.robot != robot_) return "robot";
  const bool first = keyframe.name.id == 0;
  if (!is_pose(keyframe.T_O_K) || !is_pose(keyframe.T_P_K)) return "values";
  if (!is_gravity(keyframe.gravity)) return "values";
  if (!first && !is_covariance(keyframe.covariance)) return "values";
  const auto segment = segments_.find(keyframe.name.segment);
  const int next = segment == segments_.end() ? 0 : static_cast<int>(segment->second.size());
  if (keyframe.name.id < next) return "duplicate";
  if (keyframe.name.id > next) return "gap";
  OdometryPose pose{keyframe.utime, keyframe.T_O_K, keyframe.T_P_K, {}, Matrix6d::Zero(), keyframe.gravity};
  if (!first) {
    pose.precision = precision_of(deciding_odometry_covariance(keyframe.covariance, noise_));
    pose.covariance = keyframe.covariance;
  }
  segments_[keyframe.name.segment].push_back(pose);
  return nullptr;
}

const char* RobotGraph::add(const Loop& loop) {
  if ((loop.a.robot != robot_ && loop.b.robot != robot_) || loop.a.robot < 0 || loop.b.robot < 0)
    return "robot";
  if (!is_pose(loop.T_A_B) || !is_covariance(loop.covariance) || loop.a == loop.b) return "values";
  const std::uint64_t key = key_of(loop);
  const Precision precision = precision_of(deciding_covariance(loop.covariance, noise_));
  const GraphLoop kept{key, loop.a, loop.b, loop.T_A_B, precision, false, loop.covariance};
  return loops_.emplace(key, kept).second ? nullptr : "duplicate";
}

GraphSnapshot RobotGraph::snapshot() const {
  GraphSnapshot snapshot;
  snapshot.robot = robot_;
  Hash hash;
  for (const auto& [name, poses] : segments_) {
    snapshot.segments.push_back({name, poses});
    hash.add(static_cast<std::uint64_t>(name));
    hash.add(static_cast<std::uint64_t>(poses.size()));
  }
  const auto known = [this](const KeyframeName& name) {
    const auto segment = segments_.find(name.segment);
    return segment != segments_.end() && name.id >= 0 && name.id < static_cast<int>(segment->second.size());
  };
  for (const auto& [key, loop] : loops_) {
    const bool a_mine = loop.a.robot == robot_;
    const bool b_mine = loop.b.robot == robot_;
    if ((a_mine && !known(loop.a)) || (b_mine && !known(loop.b))) continue;
    hash.add(key);
    if (a_mine && b_mine) {
      snapshot.private_loops.push_back(loop);
    } else {
      snapshot.shared_loops[a_mine ? loop.b.robot : loop.a.robot].push_back(loop);
    }
  }
  snapshot.hash = hash.value();
  return snapshot;
}

}  // namespace covey::pgo
