// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Rigid motions in the plane. The tangent is xi = [rho; theta], translation first (m, rad), and perturbs on
// the right: T * Exp(xi). The angle is kept in (-pi, pi]. The identities are those of se3.h, with
//
//   Exp([rho; theta]) = (theta, V(theta) rho),   V = [sin, -(1 - cos); 1 - cos, sin] / theta
//   Ad_T = [R, (t_y, -t_x)^T; 0, 1]
//
// Source: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", 2018, appendix C.

#include <Eigen/Core>

namespace covey {

// The same angle in (-pi, pi].
double wrap_angle(double angle);

// The 2x2 rotation by `angle`.
Eigen::Matrix2d rotation_2d(double angle);

struct SE2 {
  double angle = 0.0;
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();

  static SE2 exp(const Eigen::Vector3d& xi);
  Eigen::Vector3d log() const;
  Eigen::Matrix3d matrix() const;  // 3x3 homogeneous
  Eigen::Matrix3d adjoint() const;

  SE2 inverse() const { return {wrap_angle(-angle), rotation_2d(-angle) * -translation}; }
  SE2 operator*(const SE2& other) const {
    return {wrap_angle(angle + other.angle), rotation_2d(angle) * other.translation + translation};
  }
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const { return rotation_2d(angle) * p + translation; }

  static Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& xi);
  static Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& xi);  // |theta| < 2 pi
  static Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& xi) { return left_jacobian(-xi); }
  static Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& xi) {
    return left_jacobian_inverse(-xi);
  }
};

// The arc from a (s = 0) to b (s = 1) at constant body velocity.
inline SE2 interpolate(const SE2& a, const SE2& b, double s) {
  return a * SE2::exp(s * (a.inverse() * b).log());
}

}  // namespace covey
