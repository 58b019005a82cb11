// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/se3.h"

#include "core/geometry/rotation_series.h"

namespace covey {
namespace {

// The upper right block of the left Jacobian (Barfoot 7.86, with the signs drawn into the scalars).
Eigen::Matrix3d jacobian_coupling(const Vector6d& xi) {
  const Eigen::Matrix3d P = hat(xi.head<3>());
  const Eigen::Matrix3d F = hat(xi.tail<3>());
  const double x = xi.tail<3>().squaredNorm();
  const Eigen::Matrix3d fp = F * P;
  const Eigen::Matrix3d pf = P * F;
  const Eigen::Matrix3d fpf = fp * F;
  return 0.5 * P + rotation_series::a_minus_sin(x) * (fp + pf + fpf) +
         rotation_series::half_square_plus_cos(x) * (F * fp + pf * F - 3.0 * fpf) +
         rotation_series::fifth_order(x) * (fpf * F + F * fpf);
}

}  // namespace

SE3 SE3::exp(const Vector6d& xi) {
  return {SO3::exp(xi.tail<3>()), SO3::left_jacobian(xi.tail<3>()) * xi.head<3>()};
}

Vector6d SE3::log() const {
  const Eigen::Vector3d phi = rotation.log();
  Vector6d xi;
  xi << SO3::left_jacobian_inverse(phi) * translation, phi;
  return xi;
}

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation.matrix();
  m.topRightCorner<3, 1>() = translation;
  return m;
}

SE3 SE3::from_matrix(const Eigen::Matrix4d& m) {
  return {SO3::from_matrix(m.topLeftCorner<3, 3>()), m.topRightCorner<3, 1>()};
}

Matrix6d SE3::adjoint() const {
  const Eigen::Matrix3d R = rotation.matrix();
  Matrix6d m;
  m << R, hat(translation) * R, Eigen::Matrix3d::Zero(), R;
  return m;
}

Matrix6d SE3::left_jacobian(const Vector6d& xi) {
  const Eigen::Matrix3d J = SO3::left_jacobian(xi.tail<3>());
  Matrix6d m;
  m << J, jacobian_coupling(xi), Eigen::Matrix3d::Zero(), J;
  return m;
}

Matrix6d SE3::left_jacobian_inverse(const Vector6d& xi) {
  const Eigen::Matrix3d J = SO3::left_jacobian_inverse(xi.tail<3>());
  Matrix6d m;
  m << J, -J * jacobian_coupling(xi) * J, Eigen::Matrix3d::Zero(), J;
  return m;
}

}  // namespace covey
