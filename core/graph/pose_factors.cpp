// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/pose_factors.h"

#include <cmath>

namespace covey::graph {

Eigen::Vector3d ChordalBetween2::evaluate(const SE2& T_i, const SE2& T_j, Eigen::Matrix3d* J_i,
                                          Eigen::Matrix3d* J_j) const {
  const double rotation_scale = std::sqrt(8.0 * kappa);
  const double translation_scale = std::sqrt(tau);
  const Eigen::Matrix2d R_j_i = rotation_2d(-T_i.angle);
  const Eigen::Vector2d t_i_j = R_j_i * (T_j.translation - T_i.translation);
  const double half_angle = 0.5 * wrap_angle(T_j.angle - T_i.angle - measured.angle);
  Eigen::Vector3d r;
  r << translation_scale * (t_i_j - measured.translation), rotation_scale * std::sin(half_angle);
  if (J_i) {
    const double slope = 0.5 * rotation_scale * std::cos(half_angle);
    J_i->setZero();
    J_i->topLeftCorner<2, 2>().diagonal().setConstant(-translation_scale);
    J_i->topRightCorner<2, 1>() << translation_scale * t_i_j.y(), -translation_scale * t_i_j.x();
    (*J_i)(2, 2) = -slope;
    J_j->setZero();
    J_j->topLeftCorner<2, 2>() = translation_scale * rotation_2d(T_j.angle - T_i.angle);
    (*J_j)(2, 2) = slope;
  }
  return r;
}

Vector6d ChordalBetween3::evaluate(const SE3& T_i, const SE3& T_j, Matrix6d* J_i, Matrix6d* J_j) const {
  const double rotation_scale = std::sqrt(8.0 * kappa);
  const double translation_scale = std::sqrt(tau);
  const SO3 R_i_inverse = T_i.rotation.inverse();
  const SO3 R_i_j = R_i_inverse * T_j.rotation;
  const Eigen::Vector3d t_i_j = R_i_inverse * Eigen::Vector3d(T_j.translation - T_i.translation);
  const Eigen::Quaterniond q = (measured.rotation.inverse() * R_i_j).canonical_quaternion();
  Vector6d r;
  r << translation_scale * (t_i_j - measured.translation), rotation_scale * q.vec();
  if (J_i) {
    // q(E Exp(phi)) = q + (w I + q^) phi / 2 and q(Exp(psi) E) = q + (w I - q^) psi / 2, with psi = -R_ij^T
    // phi_i.
    const Eigen::Matrix3d w = q.w() * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d q_hat = hat(q.vec());
    J_i->setZero();
    J_i->topLeftCorner<3, 3>().diagonal().setConstant(-translation_scale);
    J_i->topRightCorner<3, 3>() = translation_scale * hat(t_i_j);
    J_i->bottomRightCorner<3, 3>() =
        -0.5 * rotation_scale * (w - q_hat) * measured.rotation.inverse().matrix();
    J_j->setZero();
    J_j->topLeftCorner<3, 3>() = translation_scale * R_i_j.matrix();
    J_j->bottomRightCorner<3, 3>() = 0.5 * rotation_scale * (w + q_hat);
  }
  return r;
}

}  // namespace covey::graph
