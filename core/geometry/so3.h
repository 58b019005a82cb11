// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Rotations in 3D. A rotation is a unit quaternion; q and -q are the same rotation. The tangent phi in R^3 is
// a rotation vector (axis times angle, rad) and perturbs on the right: R * Exp(phi). With ^ for hat:
//
//   Exp(Log(R)) = R,   Log(Exp(phi)) = phi for |phi| < pi,   Exp(-phi) = Exp(phi)^-1
//   phi^ v = phi x v,   Exp(phi) = I + phi^ + phi^ phi^ / 2 + ...
//   R Exp(phi) R^-1 = Exp(Ad_R phi),   Ad_R = R
//   Exp(phi + d) = Exp(Jl(phi) d) Exp(phi) = Exp(phi) Exp(Jr(phi) d)   to first order in d
//   Jr(phi) = Jl(-phi) = Jl(phi)^T,   Jl(phi) = Exp(phi) Jr(phi)
//   Log(R Exp(d)) = Log(R) + Jr(Log R)^-1 d   to first order in d
//
// At an angle of exactly pi, Log returns one of the two opposite vectors. Source: Sola, Deray, Atchuthan, "A
// micro Lie theory for state estimation in robotics", 2018, appendix B.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace covey {

// hat(v) * w = v x w; vee undoes it (and takes the skew part of what is not skew).
inline Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}
inline Eigen::Vector3d vee(const Eigen::Matrix3d& m) {
  return 0.5 * Eigen::Vector3d(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
}

class SO3 {
 public:
  SO3() : q_(Eigen::Quaterniond::Identity()) {}

  // Any non-zero quaternion; it is normalised.
  static SO3 from_quaternion(const Eigen::Quaterniond& q) { return SO3(q.normalized()); }
  // The rotation nearest to m in the Frobenius norm; m need not be a rotation.
  static SO3 from_matrix(const Eigen::Matrix3d& m);
  static SO3 exp(const Eigen::Vector3d& phi);
  Eigen::Vector3d log() const;

  Eigen::Matrix3d matrix() const { return q_.toRotationMatrix(); }
  Eigen::Matrix3d adjoint() const { return matrix(); }
  const Eigen::Quaterniond& quaternion() const { return q_; }
  // The one of q, -q with w >= 0: what is written to files and messages.
  Eigen::Quaterniond canonical_quaternion() const {
    return q_.w() < 0.0 ? Eigen::Quaterniond(-q_.coeffs()) : q_;
  }

  SO3 inverse() const { return SO3(q_.conjugate()); }
  SO3 operator*(const SO3& other) const {
    Eigen::Quaterniond q = q_ * other.q_;
    q.coeffs() *= 0.5 * (3.0 - q.squaredNorm());  // one Newton step keeps the norm at 1 to the last bit
    return SO3(q);
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& v) const { return q_._transformVector(v); }

  static Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi);
  static Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& phi);  // |phi| < 2 pi
  static Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& phi) { return left_jacobian(-phi); }
  static Eigen::Matrix3d right_jacobian_inverse(const Eigen::Vector3d& phi) {
    return left_jacobian_inverse(-phi);
  }

 private:
  explicit SO3(const Eigen::Quaterniond& unit) : q_(unit) {}

  Eigen::Quaterniond q_;
};

// The shortest way from a (s = 0) to b (s = 1).
inline SO3 interpolate(const SO3& a, const SO3& b, double s) {
  return a * SO3::exp(s * (a.inverse() * b).log());
}

}  // namespace covey
