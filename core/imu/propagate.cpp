// SPDX-License-Identifier: BSD-3-Clause
#include "core/imu/propagate.h"

namespace covey {

NavState propagate(const NavState& state, const ImuNoise& noise, std::span<const ImuSample> samples,
                   const Eigen::Vector3d& gravity) {
  return Preintegration(noise, state.bias, samples).predict(state, gravity);
}

Matrix15d propagate_covariance(const NavState& state, const Matrix15d& covariance,
                               const Preintegration& increment) {
  const double T = increment.duration_s();
  const ImuIncrement d = increment.corrected(state.bias);
  const Eigen::Matrix3d R = state.T_W_B.rotation.matrix();
  const Eigen::Matrix3d undo = d.dR.inverse().matrix();

  // How errors of the increment, [rho; phi; v], come in.
  Matrix9d G = Matrix9d::Zero();
  G.block<3, 3>(0, 0) = undo;
  G.block<3, 3>(3, 3).setIdentity();
  G.block<3, 3>(6, 6) = R;

  Matrix15d F = Matrix15d::Identity();
  F.block<3, 3>(0, 0) = undo;
  F.block<3, 3>(0, 3) = -undo * hat(d.dp);
  F.block<3, 3>(0, 6) = T * undo * R.transpose();
  F.block<3, 3>(3, 3) = undo;
  F.block<3, 3>(6, 3) = -R * hat(d.dv);
  F.block<9, 6>(0, 9) = G * increment.bias_jacobian();

  Matrix15d result = F * covariance * F.transpose();
  result.topLeftCorner<9, 9>() += G * increment.covariance() * G.transpose();
  const ImuNoise& noise = increment.noise();
  result.diagonal().segment<3>(9).array() += noise.gyro_walk * noise.gyro_walk * T;
  result.diagonal().tail<3>().array() += noise.accel_walk * noise.accel_walk * T;
  return 0.5 * (result + result.transpose());
}

}  // namespace covey
