// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Noise of pictures and of depth, from a seed per frame and fast enough for video: normal deviates come from a table of quantiles.

#include <array>
#include <cstdint>
#include <span>

#include "core/sim/random.h"

namespace covey::sim {

// The mid-quantiles of the standard normal distribution: entry i is the deviate below which lies (i + 1/2) / size of it.
constexpr int kNormalTableSize = 4096;
const std::array<float, kNormalTableSize>& normal_table();

// Photon and read-out noise: variance = read^2 + shot^2 * grey, in grey levels. What leaves 0 ... 255 is clipped.
class PictureNoise {
 public:
  PictureNoise(double read, double shot);
  void add(Random random, std::span<std::uint8_t> picture) const;

 private:
  // By grey level and by a random byte.
  std::array<std::array<std::uint8_t, 256>, 256> noisy_;
};

}  // namespace covey::sim
