// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/messages.h"

#include <algorithm>
#include <cmath>

namespace covey {
namespace {

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using RowMajor9f = Eigen::Matrix<float, 9, 9, Eigen::RowMajor>;

void write_pose(const SE3& pose, double (&q)[4], double (&t)[3]) {
  const Eigen::Quaterniond quaternion = pose.rotation.canonical_quaternion();
  q[0] = quaternion.w();
  q[1] = quaternion.x();
  q[2] = quaternion.y();
  q[3] = quaternion.z();
  Eigen::Vector3d::Map(&t[0]) = pose.translation;
}

}  // namespace

ImuSample sample_from(const imu_t& message) {
  return {message.utime, Eigen::Vector3d(&message.gyro[0]), Eigen::Vector3d(&message.accel[0])};
}

StereoPictures pictures_from(const stereo_t& message) {
  return {message.utime, message.width, message.height, message.left, message.right};
}

std::optional<vio::OdometryPose> odometry_from(const odometry_t& message) {
  const Eigen::Quaterniond q(message.q_O_B[0], message.q_O_B[1], message.q_O_B[2], message.q_O_B[3]);
  const Eigen::Vector3d t(&message.t_O_B[0]);
  const Matrix6d covariance = Eigen::Map<const RowMajor6d>(&message.covariance[0]);
  constexpr double kLeastNorm = 1e-3;
  if (!q.coeffs().allFinite() || q.norm() < kLeastNorm || !t.allFinite() || !covariance.allFinite()) {
    return std::nullopt;
  }
  const bool is_known = !covariance.isZero(0.0);
  if (is_known && !(covariance.diagonal().array() > 0.0).all()) return std::nullopt;
  return vio::OdometryPose{message.utime, message.segment, {SO3::from_quaternion(q), t}, covariance};
}

state_t to_message(const vio::VioState& state, int robot) {
  state_t message{};
  message.utime = state.utime;
  message.robot = robot;
  message.segment = state.segment;
  write_pose(state.state.T_W_B, message.q_O_B, message.t_O_B);
  Eigen::Vector3d::Map(&message.v_O[0]) = state.state.v_W;
  Eigen::Vector3d::Map(&message.gyro_bias[0]) = state.state.bias.gyro;
  Eigen::Vector3d::Map(&message.accel_bias[0]) = state.state.bias.accel;
  Eigen::Map<RowMajor9f>(&message.covariance[0]) = state.covariance.cast<float>();
  message.coasting = static_cast<std::int8_t>(state.coasting);
  return message;
}

keyframe_t to_message(const vio::VioKeyframe& keyframe, int robot) {
  keyframe_t message{};
  message.utime = keyframe.utime;
  message.robot = robot;
  message.segment = keyframe.segment;
  message.id = keyframe.id;
  write_pose(keyframe.T_O_K, message.q_O_K, message.t_O_K);
  write_pose(keyframe.T_P_K, message.q_P_K, message.t_P_K);
  Eigen::Map<RowMajor6d>(&message.covariance[0]) = keyframe.covariance;
  Eigen::Vector3d::Map(&message.gravity_K[0]) = keyframe.gravity_K;
  message.gravity_sigma_rad = keyframe.gravity_sigma_rad;
  return message;
}

}  // namespace covey
