// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/exposure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/sim/random.h"

namespace covey::sim {
namespace {

constexpr std::uint64_t kPhase = 0x70686173;  // of a seed's numbers, the one that is for this

std::vector<float> light_by_pixel(const PinholeCamera& camera, double vignette) {
  std::vector<float> shares;
  const Eigen::Vector2d middle(0.5 * (camera.width - 1), 0.5 * (camera.height - 1));
  shares.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double r2 = (Eigen::Vector2d(u, v) - middle).squaredNorm() / middle.squaredNorm();
      shares.push_back(static_cast<float>(1.0 - vignette * r2));
    }
  }
  return shares;
}

}  // namespace

Exposure::Exposure(const PinholeCamera& camera, const ExposureOptions& options, std::uint64_t seed)
    : options_(options),
      phase_(Random(mix_seeds(seed, kPhase)).uniform(0.0, 2.0 * std::numbers::pi)),
      shares_(options.vignette > 0.0 ? light_by_pixel(camera, options.vignette) : std::vector<float>()) {}

void Exposure::apply(Utime utime, std::span<std::uint8_t> picture) const {
  if (shares_.empty() && options_.stops <= 0.0) return;
  const double angle = 2.0 * std::numbers::pi * to_seconds(utime) / options_.period_s + phase_;
  const auto gain = static_cast<float>(std::exp2(options_.stops * std::sin(angle)));
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const float light = gain * (shares_.empty() ? 1.0F : shares_[i]) * static_cast<float>(picture[i]);
    picture[i] = static_cast<std::uint8_t>(std::min(light + 0.5F, 255.0F));
  }
}

std::vector<Utime> open_times(const ExposureOptions& options, Utime utime) {
  if (options.open_s <= 0.0 || options.steps < 2) return {utime};
  std::vector<Utime> times;
  for (int k = 0; k < options.steps; ++k)
    times.push_back(utime + from_seconds(options.open_s * ((k + 0.5) / options.steps - 0.5)));
  return times;
}

}  // namespace covey::sim
