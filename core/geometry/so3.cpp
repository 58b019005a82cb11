// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/so3.h"

#include <cmath>

#include "core/geometry/rotation_series.h"
#include "core/geometry/stiefel.h"

namespace covey {

SO3 SO3::from_matrix(const Eigen::Matrix3d& m) {
  const bool is_rotation = (m.transpose() * m).isIdentity(1e-9) && m.determinant() > 0.0;
  return from_quaternion(Eigen::Quaterniond(is_rotation ? m : Eigen::Matrix3d(project_to_rotation(m))));
}

SO3 SO3::exp(const Eigen::Vector3d& phi) {
  const double squared_half_angle = 0.25 * phi.squaredNorm();
  const Eigen::Vector3d v = 0.5 * rotation_series::sinc(squared_half_angle) * phi;
  return from_quaternion({std::cos(std::sqrt(squared_half_angle)), v.x(), v.y(), v.z()});
}

Eigen::Vector3d SO3::log() const {
  // With w >= 0 the half angle atan2(|v|, w) is in [0, pi / 2], well conditioned at both ends.
  const double sign = q_.w() < 0.0 ? -1.0 : 1.0;
  const double w = sign * q_.w();
  const double n = q_.vec().norm();
  const double half_angle_over_n = n < 1e-5 ? (1.0 - n * n / (3.0 * w * w)) / w : std::atan2(n, w) / n;
  return sign * 2.0 * half_angle_over_n * q_.vec();
}

Eigen::Matrix3d SO3::left_jacobian(const Eigen::Vector3d& phi) {
  const double x = phi.squaredNorm();
  const Eigen::Matrix3d m = hat(phi);
  return Eigen::Matrix3d::Identity() + rotation_series::one_minus_cos(x) * m +
         rotation_series::a_minus_sin(x) * m * m;
}

Eigen::Matrix3d SO3::left_jacobian_inverse(const Eigen::Vector3d& phi) {
  const Eigen::Matrix3d m = hat(phi);
  return Eigen::Matrix3d::Identity() - 0.5 * m +
         rotation_series::one_minus_half_cot(phi.squaredNorm()) * m * m;
}

}  // namespace covey
