// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/se2.h"

#include <cmath>
#include <numbers>

#include "core/geometry/rotation_series.h"

namespace covey {
namespace {

Eigen::Matrix2d spiral(double theta) {
  const double diagonal = rotation_series::sinc(theta * theta);
  const double skew = theta * rotation_series::one_minus_cos(theta * theta);
  return (Eigen::Matrix2d() << diagonal, -skew, skew, diagonal).finished();
}

Eigen::Matrix2d spiral_inverse(double theta) {
  const double diagonal = 1.0 - theta * theta * rotation_series::one_minus_half_cot(theta * theta);
  return (Eigen::Matrix2d() << diagonal, 0.5 * theta, -0.5 * theta, diagonal).finished();
}

}  // namespace

double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

Eigen::Matrix2d rotation_2d(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

SE2 SE2::exp(const Eigen::Vector3d& xi) { return {wrap_angle(xi.z()), spiral(xi.z()) * xi.head<2>()}; }

Eigen::Vector3d SE2::log() const {
  const double theta = wrap_angle(angle);
  Eigen::Vector3d xi;
  xi << spiral_inverse(theta) * translation, theta;
  return xi;
}

Eigen::Matrix3d SE2::matrix() const {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = rotation_2d(angle);
  m.topRightCorner<2, 1>() = translation;
  return m;
}

Eigen::Matrix3d SE2::adjoint() const {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = rotation_2d(angle);
  m.topRightCorner<2, 1>() << translation.y(), -translation.x();
  return m;
}

Eigen::Matrix3d SE2::left_jacobian(const Eigen::Vector3d& xi) {
  const double x = xi.z() * xi.z();
  const double along = xi.z() * rotation_series::a_minus_sin(x);
  const double across = rotation_series::one_minus_cos(x);
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = spiral(xi.z());
  m.topRightCorner<2, 1>() << along * xi.x() + across * xi.y(), along * xi.y() - across * xi.x();
  return m;
}

Eigen::Matrix3d SE2::left_jacobian_inverse(const Eigen::Vector3d& xi) {
  const Eigen::Matrix2d v_inverse = spiral_inverse(xi.z());
  const Eigen::Vector2d coupling = left_jacobian(xi).topRightCorner<2, 1>();
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = v_inverse;
  m.topRightCorner<2, 1>() = -v_inverse * coupling;
  return m;
}

}  // namespace covey
