// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/gravity_factor.h"

#include <cmath>

namespace covey::graph {
namespace {

constexpr double kSmallSine = 1e-6;

// Rows: an orthonormal basis of the plane across m.
Eigen::Matrix<double, 2, 3> basis_across(const Eigen::Vector3d& m) {
  Eigen::Index smallest = 0;
  m.cwiseAbs().minCoeff(&smallest);
  const Eigen::Vector3d a = m.cross(Eigen::Vector3d::Unit(smallest)).normalized();
  Eigen::Matrix<double, 2, 3> B;
  B << a.transpose(), m.cross(a).transpose();
  return B;
}

}  // namespace

Eigen::Vector2d GravityFactor::evaluate(const SE3& T_W_K, Eigen::Matrix<double, 2, 6>* J) const {
  const Eigen::Matrix<double, 2, 3> B = basis_across(measured_K);
  const Eigen::Vector3d u = T_W_K.rotation.inverse() * down_W;
  const Eigen::Vector2d w = B * u;
  const double sine = w.norm();
  const double cosine = measured_K.dot(u);
  if (J) J->setZero();
  if (sine < kSmallSine && cosine < 0.0) return Eigen::Vector2d::Zero();
  // r = (theta / sine) w, and u(phi) = u + u x phi for R Exp(phi).
  const Eigen::Matrix3d du = hat(u);
  if (sine < kSmallSine) {
    if (J) J->rightCols<3>() = B * du;
    return w;
  }
  const double theta = std::atan2(sine, cosine);
  if (J) {
    const Eigen::Vector2d direction = w / sine;
    const Eigen::Matrix<double, 2, 3> dw = B * du;
    const Eigen::RowVector3d dsine = direction.transpose() * dw;
    const Eigen::RowVector3d dtheta = cosine * dsine - sine * (measured_K.transpose() * du);
    J->rightCols<3>() = direction * dtheta + theta / sine * (dw - direction * dsine);
  }
  return theta / sine * w;
}

}  // namespace covey::graph
