// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace covey {
namespace {

using Coefficients = std::array<double, 4>;

constexpr double kFlat = 0.05;  // where a pixel moves less than that with its point the model turns back

// Beyond the radius where the radial model turns back a pixel has no or several points.
bool folds(const Coefficients& distortion, double r2) {
  const auto [k1, k2, p1, p2] = distortion;
  return 1.0 + r2 * (k1 + r2 * k2) < kFlat || 1.0 + r2 * (3.0 * k1 + 5.0 * r2 * k2) < kFlat;
}

Eigen::Vector2d radial_tangential(const Coefficients& distortion, const Eigen::Vector2d& m,
                                  Eigen::Matrix2d* J) {
  const auto [k1, k2, p1, p2] = distortion;
  const double x = m.x();
  const double y = m.y();
  const double r2 = m.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * k2);
  if (J) {
    const double radial_slope = 2.0 * (k1 + 2.0 * k2 * r2);  // d radial / d r^2, times 2
    const double cross = radial_slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
    *J << radial + radial_slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x, cross,  //
        cross, radial + radial_slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

// Distance from the middle at an angle, over the focal length, and its derivative.
struct Bend {
  double distance;
  double slope;
};

Bend bend(const Coefficients& k, double theta) {
  const double t2 = theta * theta;
  return {theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))),
          1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])))};
}

Eigen::Vector2d equidistant(const Coefficients& distortion, const Eigen::Vector2d& m, Eigen::Matrix2d* J) {
  const double r = m.norm();
  const Bend at = bend(distortion, std::atan(r));
  constexpr double kMiddle = 1e-6;
  const double scale = r < kMiddle ? 1.0 : at.distance / r;
  if (J) {
    const double slope = r < kMiddle ? 0.0 : (at.slope / (1.0 + r * r) - scale) / (r * r);
    *J = scale * Eigen::Matrix2d::Identity() + slope * m * m.transpose();
  }
  return scale * m;
}

std::optional<Eigen::Vector2d> from_equidistant(const Coefficients& distortion, const Eigen::Vector2d& m_d) {
  const double distance = m_d.norm();
  double theta = std::min(distance, kWidest);
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Bend at = bend(distortion, theta);
    if (at.slope < kFlat) return std::nullopt;
    const double step = (distance - at.distance) / at.slope;
    theta += step;
    if (std::abs(step) > 1e-12) continue;
    if (theta > kWidest) return std::nullopt;
    return distance < 1e-12 ? m_d : Eigen::Vector2d(std::tan(theta) / distance * m_d);
  }
  return std::nullopt;
}

}  // namespace

bool PinholeCamera::is_distorted() const {
  return lens == LensModel::kEquidistant ||
         std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; });
}

Eigen::Vector2d PinholeCamera::distort(const Eigen::Vector2d& m, Eigen::Matrix2d* J) const {
  const auto model = lens == LensModel::kEquidistant ? equidistant : radial_tangential;
  const Eigen::Vector2d m_d = model(distortion, m, J);
  if (J) *J = Eigen::Vector2d(fx, fy).asDiagonal() * *J;
  return {fx * m_d.x() + cx, fy * m_d.y() + cy};
}

std::optional<Eigen::Vector2d> PinholeCamera::undistort(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d m((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!is_distorted()) return m;
  if (lens == LensModel::kEquidistant) return from_equidistant(distortion, m);
  constexpr double kTolerancePx = 1e-6;
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Matrix2d J;
    const Eigen::Vector2d error = distort(m, &J) - pixel;
    if (folds(distortion, m.squaredNorm())) return std::nullopt;
    if (error.squaredNorm() < kTolerancePx * kTolerancePx) return m;
    m -= J.inverse() * error;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> PinholeCamera::project(const Eigen::Vector3d& p_C) const {
  if (!(p_C.z() > 1e-6)) return std::nullopt;
  return distort(p_C.head<2>() / p_C.z());
}

}  // namespace covey
