// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/camera.h"

#include <Eigen/LU>
#include <algorithm>

namespace covey {
namespace {

// Beyond the radius where the radial model turns back a pixel has no or several points.
bool folds(const std::array<double, 4>& distortion, double r2) {
  const auto [k1, k2, p1, p2] = distortion;
  constexpr double kFlat = 0.05;
  return 1.0 + r2 * (k1 + r2 * k2) < kFlat || 1.0 + r2 * (3.0 * k1 + 5.0 * r2 * k2) < kFlat;
}

}  // namespace

bool PinholeCamera::is_distorted() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0.0; });
}

Eigen::Vector2d PinholeCamera::distort(const Eigen::Vector2d& m, Eigen::Matrix2d* J) const {
  const auto [k1, k2, p1, p2] = distortion;
  const double x = m.x();
  const double y = m.y();
  const double r2 = m.squaredNorm();
  const double radial = 1.0 + r2 * (k1 + r2 * k2);
  if (J) {
    const double radial_slope = 2.0 * (k1 + 2.0 * k2 * r2);  // d radial / d r^2, times 2
    const double cross = radial_slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
    *J << fx * (radial + radial_slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x), fx * cross,  //
        fy * cross, fy * (radial + radial_slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x);
  }
  return {fx * (x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)) + cx,
          fy * (y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y) + cy};
}

std::optional<Eigen::Vector2d> PinholeCamera::undistort(const Eigen::Vector2d& pixel) const {
  Eigen::Vector2d m((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!is_distorted()) return m;
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
