// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/lens.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/error.h"

namespace covey::sim {
namespace {

Eigen::Vector2d ideal_point(const PinholeCamera& camera, int u, int v) {
  const std::optional<Eigen::Vector2d> m = camera.undistort(Eigen::Vector2d(u, v));
  if (!m)
    throw_input_error("a camera's distortion folds over at pixel ({}, {}): it cannot be simulated", u, v);
  return *m;
}

// All that the camera sees, on the plane z = 1. The extremes lie on the picture's rim.
Eigen::AlignedBox2d field_of_view(const PinholeCamera& camera) {
  Eigen::AlignedBox2d box;
  for (int u = 0; u < camera.width; ++u) {
    for (const int v : {0, camera.height - 1}) box.extend(ideal_point(camera, u, v));
  }
  for (int v = 0; v < camera.height; ++v) {
    for (const int u : {0, camera.width - 1}) box.extend(ideal_point(camera, u, v));
  }
  return box;
}

PinholeCamera covering_view(const PinholeCamera& camera, double scale) {
  const Eigen::AlignedBox2d box = field_of_view(camera);
  PinholeCamera ideal;
  ideal.fx = scale * camera.fx;
  ideal.fy = scale * camera.fy;
  constexpr double kMargin = 1.0;  // pixels
  ideal.cx = kMargin - ideal.fx * box.min().x();
  ideal.cy = kMargin - ideal.fy * box.min().y();
  ideal.width = static_cast<int>(std::ceil(ideal.fx * box.sizes().x() + 2.0 * kMargin)) + 1;
  ideal.height = static_cast<int>(std::ceil(ideal.fy * box.sizes().y() + 2.0 * kMargin)) + 1;
  return ideal;
}

}  // namespace

Lens::Lens(const PinholeCamera& camera, double scale)
    : camera_(camera), ideal_(covering_view(camera, scale)) {
  sources_.reserve(static_cast<std::size_t>(camera.width * camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d place = ideal_.distort(ideal_point(camera, u, v));
      const Eigen::Vector2i steps = (256.0 * place).array().round().cast<int>();
      sources_.push_back({static_cast<std::uint32_t>((steps.y() >> 8) * ideal_.width + (steps.x() >> 8)),
                          static_cast<std::uint16_t>(steps.x() & 255),
                          static_cast<std::uint16_t>(steps.y() & 255)});
    }
  }
}

void Lens::distort(std::span<const std::uint8_t> ideal_view, std::span<std::uint8_t> picture) const {
  COVEY_CHECK(ideal_view.size() == static_cast<std::size_t>(ideal_.width * ideal_.height));
  COVEY_CHECK(picture.size() == sources_.size());
  const auto row = static_cast<std::size_t>(ideal_.width);
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const Source& source = sources_[i];
    const std::uint8_t* from = &ideal_view[source.pixel];
    const unsigned right = source.right;
    const unsigned upper = from[0] * (256U - right) + from[1] * right;
    const unsigned lower = from[row] * (256U - right) + from[row + 1] * right;
    picture[i] =
        static_cast<std::uint8_t>((upper * (256U - source.down) + lower * source.down + 32768U) >> 16);
  }
}

}  // namespace covey::sim
