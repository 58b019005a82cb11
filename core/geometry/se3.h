// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Rigid motions in 3D. T_A_B takes coordinates in B to coordinates in A: p_A = T_A_B * p_B. The tangent is
// xi = [rho; phi], translation first (m, rad), and perturbs on the right, in the second frame: T * Exp(xi).
//
//   Exp(Log(T)) = T,   Log(Exp(xi)) = xi for |phi| < pi,   Exp([rho; phi]) = (Exp(phi), Jl(phi) rho)
//   T Exp(xi) T^-1 = Exp(Ad_T xi),   Ad_T = [R, t^ R; 0, R],   Ad_(T U) = Ad_T Ad_U
//   Exp(xi + d) = Exp(Jl(xi) d) Exp(xi) = Exp(xi) Exp(Jr(xi) d)   to first order in d
//   Jr(xi) = Jl(-xi),   Jl(xi) = Ad_Exp(xi) Jr(xi)
//   Log(T Exp(d)) = Log(T) + Jr(Log T)^-1 d   to first order in d
//   (T Exp(d))^-1 = T^-1 Exp(-Ad_T d): inverting a measurement moves its covariance by Ad_T
//
// Source: Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", 2018, appendix D;
// the block Q of the Jacobians: Barfoot, "State Estimation for Robotics", 2017, equation 7.86.

#include <Eigen/Core>

#include "core/geometry/so3.h"

namespace covey {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct SE3 {
  SO3 rotation;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  static SE3 exp(const Vector6d& xi);
  Vector6d log() const;
  // The 4x4 homogeneous matrix; from_matrix projects its 3x3 block to the nearest rotation.
  Eigen::Matrix4d matrix() const;
  static SE3 from_matrix(const Eigen::Matrix4d& m);
  Matrix6d adjoint() const;

  SE3 inverse() const {
    const SO3 r = rotation.inverse();
    return {r, r * Eigen::Vector3d(-translation)};
  }
  SE3 operator*(const SE3& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation * p + translation; }

  static Matrix6d left_jacobian(const Vector6d& xi);
  static Matrix6d left_jacobian_inverse(const Vector6d& xi);  // |phi| < 2 pi
  static Matrix6d right_jacobian(const Vector6d& xi) { return left_jacobian(-xi); }
  static Matrix6d right_jacobian_inverse(const Vector6d& xi) { return left_jacobian_inverse(-xi); }
};

// The screw motion from a (s = 0) to b (s = 1) at constant body velocity.
inline SE3 interpolate(const SE3& a, const SE3& b, double s) {
  return a * SE3::exp(s * (a.inverse() * b).log());
}

}  // namespace covey
