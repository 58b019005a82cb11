// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A pinhole camera with a lens. Camera frame C: x right, y down, z along the optical axis. With m = (x / z, y / z), r = |m|:
//
//   u = fx m_dx + cx,   v = fy m_dy + cy
//
//   radial-tangential   m_d = m (1 + k1 r^2 + k2 r^4) + [2 p1 mx my + p2 (r^2 + 2 mx^2); p1 (r^2 + 2 my^2) + 2 p2 mx my]
//   equidistant         m_d = m / r (theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9),   theta = atan r
//
// Pixel (0, 0) is the centre of the top left pixel. Sources: OpenCV's camera model (Brown 1966), as EuRoC's sensor.yaml uses it; Kannala and
// Brandt, "A Generic Camera Model and Calibration Method", PAMI 2006, for fisheye lenses. Points are on the plane z = 1, so what a fisheye lens sees at
// more than kWidest from its axis is left out.

#include <Eigen/Core>
#include <array>
#include <optional>

namespace covey {

enum class LensModel { kRadialTangential, kEquidistant };

constexpr double kWidest = 1.4;  // rad

struct PinholeCamera {
  int width = 0;
  int height = 0;
  double fx = 1.0;
  double fy = 1.0;
  double cx = 0.0;
  double cy = 0.0;
  std::array<double, 4> distortion = {};  // k1, k2, p1, p2; equidistant: k1, k2, k3, k4
  LensModel lens = LensModel::kRadialTangential;

  bool is_distorted() const;
  bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 && pixel.y() < height - 0.5;
  }

  // Of a point on the plane z = 1; J: d pixel / d m.
  Eigen::Vector2d distort(const Eigen::Vector2d& m, Eigen::Matrix2d* J = nullptr) const;
  // The inverse, by Newton's method; nothing where the model folds over (far outside of the picture) and beyond kWidest.
  std::optional<Eigen::Vector2d> undistort(const Eigen::Vector2d& pixel) const;

  // Of a point in C; nothing where it is not in front. Not limited to the picture.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_C) const;
};

}  // namespace covey
