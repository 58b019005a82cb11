// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/sensor_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace covey::sim {
namespace {

// Newton's method on the distribution function, from the quantile before.
std::array<float, kNormalTableSize> make_normal_table() {
  std::array<float, kNormalTableSize> table = {};
  double x = 0.0;
  for (int i = kNormalTableSize / 2; i < kNormalTableSize; ++i) {
    const double above = 1.0 - (i + 0.5) / kNormalTableSize;
    for (int step = 0; step < 8; ++step) {
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
      x += (0.5 * std::erfc(x / std::numbers::sqrt2) - above) / density;
    }
    table[static_cast<std::size_t>(i)] = static_cast<float>(x);
    table[static_cast<std::size_t>(kNormalTableSize - 1 - i)] = static_cast<float>(-x);
  }
  return table;
}

}  // namespace

const std::array<float, kNormalTableSize>& normal_table() {
  static const std::array<float, kNormalTableSize> kTable = make_normal_table();
  return kTable;
}

PictureNoise::PictureNoise(double read, double shot) {
  constexpr std::size_t kStep = kNormalTableSize / 256;
  for (std::size_t grey = 0; grey < 256; ++grey) {
    const double sigma = std::sqrt(read * read + shot * shot * static_cast<double>(grey));
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const double value = static_cast<double>(grey) + sigma * normal_table()[kStep * byte + kStep / 2];
      noisy_[grey][byte] = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    }
  }
}

void PictureNoise::add(Random random, std::span<std::uint8_t> picture) const {
  for (std::size_t i = 0; i < picture.size(); i += 8) {
    std::uint64_t bytes = random.next();
    const std::size_t end = std::min(i + 8, picture.size());
    for (std::size_t j = i; j < end; ++j) {
      picture[j] = noisy_[picture[j]][bytes & 255];
      bytes >>= 8;
    }
  }
}

}  // namespace covey::sim
