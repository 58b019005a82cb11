// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/online.h"

#include <cmath>
#include <optional>

namespace covey {
namespace {

// q: w, x, y, z; t in m.
std::optional<SE3> pose_from(const double* q, const double* t) {
  const Eigen::Quaterniond quaternion(q[0], q[1], q[2], q[3]);
  const Eigen::Vector3d translation(t[0], t[1], t[2]);
  if (!(std::abs(quaternion.norm() - 1.0) < 0.01) || !translation.allFinite()) return std::nullopt;
  return SE3{SO3::from_quaternion(quaternion), translation};
}

}  // namespace

void OnlineTrajectory::take(const keyframe_t& keyframe) {
  const auto T_O_K = pose_from(keyframe.q_O_K, keyframe.t_O_K);
  if (keyframe.robot != robot_ || !T_O_K) return;
  const Name name{keyframe.segment, keyframe.id};
  if (!T_O_K_.emplace(name, *T_O_K).second) return;
  // The newest solved keyframe of the same segment, up to this one, whose odometry was heard.
  for (auto solved = T_W_K_.upper_bound(name); solved != T_W_K_.begin();) {
    --solved;
    if (solved->first.first != keyframe.segment) return;
    const auto odometry = T_O_K_.find(solved->first);
    if (odometry == T_O_K_.end()) continue;
    believed_.emplace(keyframe.utime, solved->second * odometry->second.inverse() * *T_O_K);
    return;
  }
}

void OnlineTrajectory::take(const trajectory_t& part) {
  if (part.robot != robot_ || part.n_values != 7 * part.n) return;
  if (!parts_.empty() && parts_.begin()->second.utime != part.utime) parts_.clear();
  parts_[part.part] = part;
  if (static_cast<int>(parts_.size()) >= part.parts) finish_round();
}

void OnlineTrajectory::finish_round() {
  if (parts_.begin()->second.anchor == anchor_) {
    T_W_K_.clear();
    for (const auto& [number, part] : parts_) {
      for (int k = 0; k < part.n; ++k) {
        const double* values = &part.T_W_K[static_cast<std::size_t>(7) * k];
        if (const auto pose = pose_from(values, values + 4)) {
          T_W_K_.emplace(Name{part.segments[k], part.ids[k]}, *pose);
        }
      }
    }
  }
  parts_.clear();
}

Trajectory OnlineTrajectory::believed() const {
  Trajectory trajectory;
  for (const auto& [utime, pose] : believed_) trajectory.push_back({utime, pose});
  return trajectory;
}

}  // namespace covey
