// SPDX-License-Identifier: BSD-3-Clause
#include "core/imu/imu_factor.h"

#include <cmath>

namespace covey {

Vector9d ImuFactor::evaluate(const SE3& T_i, const Eigen::Vector3d& v_i, const Vector6d& bias_i,
                             const SE3& T_j, const Eigen::Vector3d& v_j, PoseJacobian* J_T_i,
                             VelocityJacobian* J_v_i, PoseJacobian* J_bias, PoseJacobian* J_T_j,
                             VelocityJacobian* J_v_j) const {
  const double T = increment.duration_s();
  const Vector6d bias_change = bias_i - increment.bias().vector();
  const Vector9d by_bias = increment.bias_jacobian() * bias_change;
  const ImuIncrement& d = increment.increment();
  const SO3 R_i_inverse = T_i.rotation.inverse();
  const SO3 R_i_j = R_i_inverse * T_j.rotation;
  const Eigen::Vector3d p =
      R_i_inverse * Eigen::Vector3d(T_j.translation - T_i.translation - T * v_i - 0.5 * T * T * gravity);
  const Eigen::Vector3d v = R_i_inverse * Eigen::Vector3d(v_j - v_i - T * gravity);
  const SO3 dR = d.dR * SO3::exp(by_bias.segment<3>(3));
  Vector9d r;
  r << p - d.dp - by_bias.head<3>(), (dR.inverse() * R_i_j).log(), v - d.dv - by_bias.tail<3>();
  if (J_T_i) {
    const Eigen::Vector3d r_phi = r.segment<3>(3);
    const Eigen::Matrix3d Jr_inverse = SO3::right_jacobian_inverse(r_phi);
    const Eigen::Matrix3d R_inverse = R_i_inverse.matrix();
    J_T_i->setZero();
    J_T_i->block<3, 3>(0, 0).diagonal().setConstant(-1.0);
    J_T_i->block<3, 3>(0, 3) = hat(p);
    J_T_i->block<3, 3>(3, 3) = -Jr_inverse * R_i_j.inverse().matrix();
    J_T_i->block<3, 3>(6, 3) = hat(v);
    J_v_i->setZero();
    J_v_i->block<3, 3>(0, 0) = -T * R_inverse;
    J_v_i->block<3, 3>(6, 0) = -R_inverse;
    *J_bias = -increment.bias_jacobian();
    J_bias->middleRows<3>(3) = -Jr_inverse * SO3::exp(-r_phi).matrix() *
                               SO3::right_jacobian(by_bias.segment<3>(3)) *
                               increment.bias_jacobian().middleRows<3>(3);
    J_T_j->setZero();
    J_T_j->block<3, 3>(0, 0) = R_i_j.matrix();
    J_T_j->block<3, 3>(3, 3) = Jr_inverse;
    J_v_j->setZero();
    J_v_j->block<3, 3>(6, 0) = R_inverse;
  }
  return r;
}

Vector6d BiasWalk::evaluate(const Vector6d& b_i, const Vector6d& b_j, Matrix6d* J_i, Matrix6d* J_j) const {
  if (J_i) {
    *J_i = -Matrix6d::Identity();
    J_j->setIdentity();
  }
  return b_j - b_i;
}

graph::Noise<9> imu_noise(const Preintegration& increment) {
  return graph::Noise<9>::covariance(increment.covariance());
}

graph::Noise<6> bias_walk_noise(const ImuNoise& imu, double duration_s) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(imu.gyro_walk), Eigen::Vector3d::Constant(imu.accel_walk);
  return graph::Noise<6>::sigmas(std::sqrt(duration_s) * sigmas);
}

}  // namespace covey
