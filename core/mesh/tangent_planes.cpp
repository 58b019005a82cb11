// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/tangent_planes.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace covey::mesh {
namespace {

constexpr int kPairs = 3;
constexpr float kSigmas = 3.0F;  // of noise that is not taken for a bend

struct Slope {
  float per_px = 0.0F;
  float sum = 0.0F;  // of the neighbours that count
  int count = 0;
  bool in_the_air = false;
};

// Of the inverse depth at `w`, along the line of pixels that are `step` apart; `before` and `after` of them are in the image.
Slope slope_along(const float* w, std::ptrdiff_t step, int before, int after, float tolerance_m) {
  const float centre = w[0];
  const float most_bend = 2.0F * tolerance_m * centre * centre;
  const int pairs = std::min({kPairs, before, after});
  Slope slope;
  float moment = 0.0F;
  float squares = 0.0F;
  for (int k = 1; k <= pairs; ++k) {
    const float left = w[-k * step];
    const float right = w[k * step];
    if (left <= 0.0F || right <= 0.0F || std::abs(left - 2.0F * centre + right) > most_bend) break;
    moment += static_cast<float>(k) * (right - left);
    squares += static_cast<float>(2 * k * k);
    slope.sum += left + right;
    slope.count += 2;
  }
  if (slope.count > 0) {
    slope.per_px = moment / squares;
  } else if (pairs > 0 && w[-step] > 0.0F && w[step] > 0.0F) {
    const float z = 1.0F / centre;
    slope.in_the_air = std::abs(1.0F / w[-step] - z) > 2.0F * tolerance_m &&
                       std::abs(1.0F / w[step] - z) > 2.0F * tolerance_m;
  }
  return slope;
}

}  // namespace

void TangentPlanes::compute(const depth_t& image, const DepthCamera& depth_camera,
                            const PlaneOptions& options) {
  const PinholeCamera& camera = depth_camera.camera;
  const int height = camera.height;
  width_ = camera.width;
  const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height);
  COVEY_CHECK(image.width == width_ && image.height == height && image.depth_mm.size() == pixels);
  inverse_depth_.resize(pixels);
  farthest_m_ = 0.0F;
  for (std::size_t i = 0; i < pixels; ++i) {
    const float z = 0.001F * static_cast<float>(image.depth_mm[i]);
    const bool usable =
        z >= static_cast<float>(depth_camera.near_m) && z <= static_cast<float>(depth_camera.far_m);
    inverse_depth_[i] = usable ? 1.0F / z : 0.0F;
    if (usable) farthest_m_ = std::max(farthest_m_, z);
  }
  planes_.assign(pixels, {});
  points_.resize(pixels);
  const auto fx = static_cast<float>(camera.fx);
  const auto fy = static_cast<float>(camera.fy);
  for (int v = 0; v < height; ++v) {
    const float my = (static_cast<float>(v) - static_cast<float>(camera.cy)) / fy;
    for (int u = 0; u < width_; ++u) {
      const auto i = static_cast<std::size_t>(v * width_ + u);
      const float* w = &inverse_depth_[i];
      if (*w <= 0.0F) continue;
      const float tolerance_m = options.bend_m + kSigmas * options.noise_m / (*w * *w);
      const Slope along_x = slope_along(w, 1, u, width_ - 1 - u, tolerance_m);
      const Slope along_y = slope_along(w, width_, v, height - 1 - v, tolerance_m);
      if (along_x.in_the_air || along_y.in_the_air) continue;
      const float mx = (static_cast<float>(u) - static_cast<float>(camera.cx)) / fx;
      const float ax = along_x.per_px * fx;
      const float ay = along_y.per_px * fy;
      const float smooth =
          (*w + along_x.sum + along_y.sum) / static_cast<float>(1 + along_x.count + along_y.count);
      const Eigen::Vector3f a(ax, ay, smooth - ax * mx - ay * my);
      planes_[i] = {a, 1.0F / a.norm()};
      points_[i] = Eigen::Vector3f(mx, my, 1.0F) / smooth;
    }
  }
}

}  // namespace covey::mesh
