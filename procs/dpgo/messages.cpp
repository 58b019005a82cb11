// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/messages.h"

#include <algorithm>
#include <cmath>

namespace covey {
namespace {

constexpr std::size_t kPartSize = 400;

std::optional<SE3> pose_from(const double (&q)[4], const double (&t)[3]) {
  const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
  if (!(std::abs(quaternion.norm() - 1.0) < 0.01)) return std::nullopt;
  return SE3{SO3::from_quaternion(quaternion), {t[0], t[1], t[2]}};
}

Matrix6d covariance_from(const double (&values)[36]) {
  return Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(values);
}

pgo::Gravity gravity_from(const keyframe_t& message) {
  const Eigen::Vector3d down_K = Eigen::Vector3d::Map(&message.gravity_K[0]);
  return down_K.isZero() ? pgo::Gravity{} : pgo::Gravity{down_K, message.gravity_sigma_rad};
}

std::size_t parts_of(std::size_t n) { return std::max<std::size_t>(1, (n + kPartSize - 1) / kPartSize); }

struct PlacedPose {
  Utime segment;
  int id;
  Utime utime;
  SE3 T_W_K;
};

std::vector<PlacedPose> placed_poses(const pgo::RoundResult& result, const pgo::GraphSnapshot& graph) {
  std::vector<PlacedPose> poses;
  for (const pgo::SegmentResult& segment : result.segments) {
    if (!segment.placed) continue;
    const auto known = std::find_if(graph.segments.begin(), graph.segments.end(),
                                    [&](const pgo::Segment& s) { return s.name == segment.segment; });
    for (std::size_t k = 0; k < segment.T_W_K.size(); ++k) {
      poses.push_back({segment.segment, static_cast<int>(k), known->poses[k].utime, segment.T_W_K[k]});
    }
  }
  return poses;
}

}  // namespace

std::optional<pgo::Keyframe> keyframe_from(const keyframe_t& message) {
  const auto T_O_K = pose_from(message.q_O_K, message.t_O_K);
  const auto T_P_K = pose_from(message.q_P_K, message.t_P_K);
  if (!T_O_K || !T_P_K) return std::nullopt;
  return pgo::Keyframe{{message.robot, message.segment, message.id}, message.utime,        *T_O_K, *T_P_K,
                       covariance_from(message.covariance),          gravity_from(message)};
}

std::optional<pgo::Loop> loop_from(const loop_t& message) {
  const auto T_A_B = pose_from(message.q_A_B, message.t_A_B);
  if (!T_A_B) return std::nullopt;
  return pgo::Loop{{message.robot_a, message.segment_a, message.id_a},
                   {message.robot_b, message.segment_b, message.id_b},
                   *T_A_B,
                   covariance_from(message.covariance)};
}

std::vector<trajectory_t> trajectory_messages(const pgo::RoundResult& result, const pgo::GraphSnapshot& graph,
                                              Utime now) {
  const std::vector<PlacedPose> poses = placed_poses(result, graph);
  std::vector<trajectory_t> parts(parts_of(poses.size()));
  for (std::size_t part = 0; part < parts.size(); ++part) {
    trajectory_t& message = parts[part];
    message = {};
    message.utime = now;
    message.robot = graph.robot;
    message.anchor = result.anchor;
    message.round = result.name.number;
    message.part = static_cast<std::int32_t>(part);
    message.parts = static_cast<std::int32_t>(parts.size());
    message.total_poses = static_cast<std::int32_t>(poses.size());
    for (std::size_t k = part * kPartSize; k < std::min(poses.size(), (part + 1) * kPartSize); ++k) {
      const Eigen::Quaterniond q = poses[k].T_W_K.rotation.canonical_quaternion();
      const Eigen::Vector3d& t = poses[k].T_W_K.translation;
      message.segments.push_back(poses[k].segment);
      message.ids.push_back(poses[k].id);
      message.utimes.push_back(poses[k].utime);
      message.T_W_K.insert(message.T_W_K.end(), {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
    }
    message.n = static_cast<std::int32_t>(message.ids.size());
    message.n_values = static_cast<std::int32_t>(message.T_W_K.size());
  }
  return parts;
}

std::vector<loop_weights_t> loop_weights_messages(const pgo::RoundResult& result, int robot, Utime now) {
  std::vector<loop_weights_t> parts(parts_of(result.loops.size()));
  for (std::size_t part = 0; part < parts.size(); ++part) {
    loop_weights_t& message = parts[part];
    message = {};
    message.utime = now;
    message.robot = robot;
    message.round = result.name.number;
    message.part = static_cast<std::int32_t>(part);
    message.parts = static_cast<std::int32_t>(parts.size());
    for (std::size_t k = part * kPartSize; k < std::min(result.loops.size(), (part + 1) * kPartSize); ++k) {
      const pgo::LoopResult& loop = result.loops[k];
      message.robots_a.push_back(loop.loop.a.robot);
      message.segments_a.push_back(loop.loop.a.segment);
      message.ids_a.push_back(loop.loop.a.id);
      message.robots_b.push_back(loop.loop.b.robot);
      message.segments_b.push_back(loop.loop.b.segment);
      message.ids_b.push_back(loop.loop.b.id);
      message.weights.push_back(loop.weight);
      message.residuals_sq.push_back(loop.r2);
    }
    message.n = static_cast<std::int32_t>(message.weights.size());
  }
  return parts;
}

Trajectory trajectory_of(const pgo::RoundResult& result, const pgo::GraphSnapshot& graph) {
  Trajectory trajectory;
  for (const PlacedPose& pose : placed_poses(result, graph)) trajectory.push_back({pose.utime, pose.T_W_K});
  std::stable_sort(trajectory.begin(), trajectory.end(),
                   [](const StampedPose& a, const StampedPose& b) { return a.utime < b.utime; });
  return trajectory;
}

}  // namespace covey
