// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The motion that a stretch of IMU samples from t_i to t_j tells, without knowing where it began. With T = t_j - t_i:
//
//   R_j = R_i dR,   v_j = v_i + g T + R_i dv,   p_j = p_i + v_i T + g T^2 / 2 + R_i dp
//
// Between two samples the midpoint rule: the mean of both angular rates turns, the mean of both specific forces, each turned by the
// rotation at its own end, accelerates. (Holding the first sample instead is a time offset of half a sample, 2.5 ms at 200 Hz.)
//
// Errors of the increment are [rho; phi; v]: dp + rho, dR Exp(phi), dv + v, all of them in B at t_i but phi in B at t_j. The covariance is
// that of white noise of gyro and accelerometer. The increment is linear in the bias around the one it was integrated with. Source: Forster,
// Carlone, Dellaert, Scaramuzza, "On-Manifold Preintegration for Real-Time Visual-Inertial Odometry", T-RO 2017, equations 33, 35, 44, 62, 63.

#include <span>

#include "core/geometry/rig.h"
#include "core/imu/state.h"

namespace covey {

struct ImuIncrement {
  SO3 dR;
  Eigen::Vector3d dv = Eigen::Vector3d::Zero();
  Eigen::Vector3d dp = Eigen::Vector3d::Zero();
};

class Preintegration {
 public:
  using BiasJacobian = Eigen::Matrix<double, 9, 6>;  // d [rho; phi; v] / d [b_g; b_a]

  Preintegration(const ImuNoise& noise, const ImuBias& bias) : noise_(noise), bias_(bias) {}
  // Of samples in order of time, the first at t_i, the last at t_j.
  Preintegration(const ImuNoise& noise, const ImuBias& bias, std::span<const ImuSample> samples);

  // Goes on from `first`, where the increment ends, to `second`.
  void add(const ImuSample& first, const ImuSample& second);

  double duration_s() const { return duration_s_; }  // T
  const ImuNoise& noise() const { return noise_; }
  const ImuBias& bias() const { return bias_; }  // integrated with
  const ImuIncrement& increment() const { return increment_; }
  const Matrix9d& covariance() const { return covariance_; }
  const BiasJacobian& bias_jacobian() const { return bias_jacobian_; }

  // The increment for another bias, to first order.
  ImuIncrement corrected(const ImuBias& bias) const;
  // Where a state at t_i is at t_j; with its own bias, which stays.
  NavState predict(const NavState& state, const Eigen::Vector3d& gravity = kGravity) const;

 private:
  ImuNoise noise_;
  ImuBias bias_;
  double duration_s_ = 0.0;
  ImuIncrement increment_;
  Matrix9d covariance_ = Matrix9d::Zero();
  BiasJacobian bias_jacobian_ = BiasJacobian::Zero();
};

}  // namespace covey
