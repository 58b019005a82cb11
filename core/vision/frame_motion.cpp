// SPDX-License-Identifier: BSD-3-Clause
#include "core/vision/frame_motion.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace covey {
namespace {

constexpr double kBehind = 1e-3;

Eigen::Vector3d place_of(const TrackFlow& flow, const SE3& T_cur_prev, double inverse_depth) {
  return T_cur_prev.rotation * flow.from.homogeneous() + inverse_depth * T_cur_prev.translation;
}

// One weighted Gauss-Newton step on [t; phi]; scale: of the residual at which a weight has fallen to a quarter.
void step(const std::vector<TrackFlow>& flows, const SO3& R_predicted, double scale,
          const FrameMotionOptions& options, SE3& T_cur_prev) {
  const double information = 9.0 / (options.threshold * options.threshold);  // the threshold is three sigma
  Matrix6d H = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  for (const TrackFlow& flow : flows) {
    if (!flow.inverse_depth) continue;
    const Eigen::Vector3d q = place_of(flow, T_cur_prev, *flow.inverse_depth);
    if (q.z() < kBehind) continue;
    const Eigen::Vector2d m = q.head<2>() / q.z();
    const Eigen::Vector2d residual = m - flow.to;
    Eigen::Matrix<double, 2, 3> J_q;
    J_q << 1.0 / q.z(), 0.0, -m.x() / q.z(), 0.0, 1.0 / q.z(), -m.y() / q.z();
    Eigen::Matrix<double, 2, 6> J;
    J.leftCols<3>() = *flow.inverse_depth * J_q;
    J.rightCols<3>() = -J_q * hat(T_cur_prev.rotation * flow.from.homogeneous());
    const double root_weight = 1.0 / (1.0 + residual.squaredNorm() / (scale * scale));
    const double weight = information * root_weight * root_weight;
    H += weight * J.transpose() * J;
    g += weight * J.transpose() * residual;
  }
  const double translation_information = 1.0 / (options.translation_sigma_m * options.translation_sigma_m);
  const double rotation_information = 1.0 / (options.rotation_sigma_rad * options.rotation_sigma_rad);
  H.diagonal().head<3>().array() += translation_information;
  H.diagonal().tail<3>().array() += rotation_information;
  g.head<3>() += translation_information * T_cur_prev.translation;
  g.tail<3>() += rotation_information * (T_cur_prev.rotation * R_predicted.inverse()).log();
  const Vector6d change = -H.ldlt().solve(g);
  T_cur_prev.translation += change.head<3>();
  T_cur_prev.rotation = SO3::exp(change.tail<3>()) * T_cur_prev.rotation;
}

// Of `to` from the segment on which the point may be seen.
double distance_from_segment(const TrackFlow& flow, const SE3& T_cur_prev, double lowest, double highest) {
  const Eigen::Vector3d q_far = place_of(flow, T_cur_prev, lowest);
  const Eigen::Vector3d q_near = place_of(flow, T_cur_prev, highest);
  const Eigen::Vector2d far = q_far.head<2>() / std::max(q_far.z(), kBehind);
  const Eigen::Vector2d along = q_near.head<2>() / std::max(q_near.z(), kBehind) - far;
  const double length2 = std::max(along.squaredNorm(), 1e-18);
  const double s = std::clamp(along.dot(flow.to - far) / length2, 0.0, 1.0);
  return (far + s * along - flow.to).norm();
}

}  // namespace

std::optional<FrameMotion> estimate_frame_motion(const std::vector<TrackFlow>& flows, const SO3& R_cur_prev,
                                                 const FrameMotionOptions& options) {
  const auto has_depth = [](const TrackFlow& flow) { return flow.inverse_depth.has_value(); };
  const auto with_depth = std::count_if(flows.begin(), flows.end(), has_depth);
  if (with_depth < options.fewest) return std::nullopt;

  FrameMotion motion;
  motion.T_cur_prev.rotation = R_cur_prev;
  constexpr double kFirstScale = 32.0;
  for (double scale = kFirstScale; scale >= 1.0; scale /= 2.0) {
    step(flows, R_cur_prev, scale * options.threshold, options, motion.T_cur_prev);
  }
  for (int i = 0; i < 2; ++i) step(flows, R_cur_prev, options.threshold, options, motion.T_cur_prev);

  int agreeing = 0;
  motion.inliers.reserve(flows.size());
  for (const TrackFlow& flow : flows) {
    const double slack = 3.0 * options.inverse_depth_sigma;
    const double lowest = flow.inverse_depth ? std::max(0.0, *flow.inverse_depth - slack) : 0.0;
    const double highest = flow.inverse_depth ? *flow.inverse_depth + slack : 1.0 / options.nearest_m;
    const double distance = distance_from_segment(flow, motion.T_cur_prev, lowest, highest);
    const bool inlier = distance < options.threshold;
    motion.inliers.push_back(inlier);
    motion.count += inlier ? 1 : 0;
    agreeing += inlier && flow.inverse_depth ? 1 : 0;
  }
  if (agreeing < options.fewest || 2 * agreeing < with_depth) return std::nullopt;
  return motion;
}

}  // namespace covey
