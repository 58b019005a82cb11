// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/given_odometry.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace covey {
namespace {

constexpr double kKeyframeM = 0.5;
constexpr double kKeyframeRad = 15.0 * 3.14159265358979 / 180.0;
constexpr Utime kKeyframeUs = kUsPerSecond;
constexpr double kSigmaM = 0.01;
constexpr double kSigmaRad = 0.0035;

void put(const SE3& pose, double (&q)[4], double (&t)[3]) {
  const Eigen::Quaterniond rotation = pose.rotation.canonical_quaternion();
  q[0] = rotation.w();
  q[1] = rotation.x();
  q[2] = rotation.y();
  q[3] = rotation.z();
  std::copy_n(pose.translation.data(), 3, t);
}

// The diagonal of a matrix of `side` rows: 3 of translation, 3 of rotation, the rest zero.
template <typename T>
void put_covariance(std::span<T> matrix, std::size_t side) {
  for (std::size_t i = 0; i < 6; ++i) {
    const double sigma = i < 3 ? kSigmaM : kSigmaRad;
    matrix[i * side + i] = static_cast<T>(sigma * sigma);
  }
}

}  // namespace

GivenOdometry::Said GivenOdometry::add(Utime utime, const SE3& T_O_B) {
  const bool first = next_id_ == 0;
  if (first) segment_ = utime;
  Said said{};
  said.state.utime = utime;
  said.state.robot = robot_;
  said.state.segment = segment_;
  put(T_O_B, said.state.q_O_B, said.state.t_O_B);
  put_covariance<float>(said.state.covariance, 9);
  if (!first && utime > last_utime_) {
    const Eigen::Vector3d v_O =
        (T_O_B.translation - last_T_O_B_.translation) / to_seconds(utime - last_utime_);
    std::copy_n(v_O.data(), 3, said.state.v_O);
  }
  last_utime_ = utime;
  last_T_O_B_ = T_O_B;

  const SE3 T_K_B = first ? SE3{} : T_O_K_.inverse() * T_O_B;
  if (!first && utime - keyframe_utime_ < kKeyframeUs && T_K_B.translation.norm() < kKeyframeM &&
      T_K_B.rotation.log().norm() < kKeyframeRad) {
    return said;
  }
  keyframe_t keyframe{};
  keyframe.utime = utime;
  keyframe.robot = robot_;
  keyframe.segment = segment_;
  keyframe.id = next_id_++;
  put(T_O_B, keyframe.q_O_K, keyframe.t_O_K);
  put(T_K_B, keyframe.q_P_K, keyframe.t_P_K);
  if (!first) put_covariance<double>(keyframe.covariance, 6);
  keyframe_utime_ = utime;
  T_O_K_ = T_O_B;
  said.keyframe = keyframe;
  return said;
}

}  // namespace covey
