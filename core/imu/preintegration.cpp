// SPDX-License-Identifier: BSD-3-Clause
#include "core/imu/preintegration.h"

#include <cmath>

namespace covey {
namespace {

// Of position, per second of integration, m^2 / s: what the midpoint rule misses; it also keeps the covariance of a single step, where
// position and velocity move as one, invertible.
constexpr double kIntegrationVariance = 1e-10;

// Where samples are lost nobody knows what happened between: as if readings walked at random from one to the other. Of such a Brownian bridge the mean over dt has
// a variance of q^2 dt / 12, and its second integral one of q^2 dt^5 / 720 where the first is known.
constexpr double kLostStep = 2.5;      // sampling intervals: a longer step has lost samples
constexpr double kGyroWander = 4.0;    // q, rad/s per square root of a second: a vehicle that flies briskly
constexpr double kAccelWander = 15.0;  // m/s^2 per square root of a second

bool lost_samples(const ImuNoise& noise, double dt) { return dt * noise.rate_hz > kLostStep; }

// What is made up is off by as much as such a vehicle turns and accelerates, for some tenths of a second each way.
constexpr double kGyroUnknown = 0.8;   // rad/s per square root of a hertz
constexpr double kAccelUnknown = 2.5;  // m/s^2 per square root of a hertz

Vector6d reading_variances(const ImuNoise& noise, double dt, bool measured) {
  double gyro = noise.gyro_noise * noise.gyro_noise / dt;
  double accel = noise.accel_noise * noise.accel_noise / dt;
  if (!measured) {
    gyro += kGyroUnknown * kGyroUnknown / dt;
    accel += kAccelUnknown * kAccelUnknown / dt;
  } else if (lost_samples(noise, dt)) {
    gyro += kGyroWander * kGyroWander * dt / 12.0;
    accel += kAccelWander * kAccelWander * dt / 12.0;
  }
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(gyro), Eigen::Vector3d::Constant(accel);
  return variances;
}

double position_variance(const ImuNoise& noise, double dt) {
  const double lost = lost_samples(noise, dt) ? kAccelWander * kAccelWander * std::pow(dt, 5) / 720.0 : 0.0;
  return kIntegrationVariance * dt + lost;
}

}  // namespace

Preintegration::Preintegration(const ImuNoise& noise, const ImuBias& bias, std::span<const ImuSample> samples)
    : Preintegration(noise, bias) {
  for (std::size_t k = 1; k < samples.size(); ++k) add(samples[k - 1], samples[k]);
}

void Preintegration::add(const ImuSample& first, const ImuSample& second) {
  const double dt = to_seconds(second.utime - first.utime);
  if (dt <= 0.0) return;
  const Eigen::Vector3d turn = dt * (0.5 * (first.gyro + second.gyro) - bias_.gyro);
  const Eigen::Vector3d f_first = first.accel - bias_.accel;
  const Eigen::Vector3d f_second = second.accel - bias_.accel;
  const SO3 step = SO3::exp(turn);
  const SO3 after = increment_.dR * step;
  const Eigen::Matrix3d R_before = increment_.dR.matrix();
  const Eigen::Matrix3d R_after = after.matrix();
  const Eigen::Vector3d a = 0.5 * (R_before * f_first + R_after * f_second);

  // Errors after the step from those before, A, and from errors of the mean gyro and accelerometer reading, B.
  const Eigen::Matrix3d step_inverse = step.inverse().matrix();
  const Eigen::Matrix3d turn_by_gyro = dt * SO3::right_jacobian(turn);
  const Eigen::Matrix3d a_by_turn_after = -0.5 * R_after * hat(f_second);
  const Eigen::Matrix3d a_by_turn = -0.5 * R_before * hat(f_first) + a_by_turn_after * step_inverse;
  const Eigen::Matrix3d a_by_gyro = a_by_turn_after * turn_by_gyro;
  const Eigen::Matrix3d a_by_accel = 0.5 * (R_before + R_after);
  Matrix9d A = Matrix9d::Identity();
  A.block<3, 3>(0, 3) = 0.5 * dt * dt * a_by_turn;
  A.block<3, 3>(0, 6).diagonal().setConstant(dt);
  A.block<3, 3>(3, 3) = step_inverse;
  A.block<3, 3>(6, 3) = dt * a_by_turn;
  BiasJacobian B = BiasJacobian::Zero();
  B.block<3, 3>(0, 0) = 0.5 * dt * dt * a_by_gyro;
  B.block<3, 3>(0, 3) = 0.5 * dt * dt * a_by_accel;
  B.block<3, 3>(3, 0) = turn_by_gyro;
  B.block<3, 3>(6, 0) = dt * a_by_gyro;
  B.block<3, 3>(6, 3) = dt * a_by_accel;

  const Vector6d variances = reading_variances(noise_, dt, first.measured && second.measured);
  covariance_ = A * covariance_ * A.transpose() + B * variances.asDiagonal() * B.transpose();
  covariance_.topLeftCorner<3, 3>().diagonal().array() += position_variance(noise_, dt);
  bias_jacobian_ = A * bias_jacobian_ - B;

  increment_.dp += dt * increment_.dv + 0.5 * dt * dt * a;
  increment_.dv += dt * a;
  increment_.dR = after;
  duration_s_ += dt;
}

ImuIncrement Preintegration::corrected(const ImuBias& bias) const {
  const Vector9d d = bias_jacobian_ * (bias.vector() - bias_.vector());
  return {increment_.dR * SO3::exp(d.segment<3>(3)), increment_.dv + d.tail<3>(),
          increment_.dp + d.head<3>()};
}

NavState Preintegration::predict(const NavState& state, const Eigen::Vector3d& gravity) const {
  const ImuIncrement d = corrected(state.bias);
  const SO3& R = state.T_W_B.rotation;
  NavState next = state;
  next.T_W_B.rotation = R * d.dR;
  next.T_W_B.translation += duration_s_ * state.v_W + 0.5 * duration_s_ * duration_s_ * gravity + R * d.dp;
  next.v_W += duration_s_ * gravity + R * d.dv;
  return next;
}

}  // namespace covey
