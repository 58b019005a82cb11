// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/canvas.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace covey::sim {

Paint scaled(const Paint& paint, double factor) {
  const auto f = static_cast<float>(factor);
  return {paint.r * f, paint.g * f, paint.b * f};
}

Paint random_paint(Random& random, double darkest, double lightest) {
  const auto channel = [&] { return static_cast<float>(random.uniform(darkest, lightest)); };
  return {channel(), channel(), channel()};
}

Canvas::Canvas(int side) : side_(side), texels_(static_cast<std::size_t>(side * side)) {
  COVEY_CHECK(side > 0 && (side & (side - 1)) == 0);
}

Paint& Canvas::at(int column, int row) {
  const int mask = side_ - 1;
  return texels_[static_cast<std::size_t>((row & mask) * side_ + (column & mask))];
}

void Canvas::fill(const Paint& paint) { std::fill(texels_.begin(), texels_.end(), paint); }

template <typename Inside>
void Canvas::paint_box(double x0, double y0, double x1, double y1, const Paint& paint, const Inside& inside) {
  // A texel belongs to a shape that holds its centre.
  const int left = static_cast<int>(std::ceil(x0 * side_ - 0.5));
  const int right = static_cast<int>(std::ceil(x1 * side_ - 0.5));
  const int top = static_cast<int>(std::ceil(y0 * side_ - 0.5));
  const int bottom = static_cast<int>(std::ceil(y1 * side_ - 0.5));
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; ++column) {
      if (inside((column + 0.5) / side_, (row + 0.5) / side_)) at(column, row) = paint;
    }
  }
}

void Canvas::rectangle(double x, double y, double width, double height, const Paint& paint) {
  paint_box(x, y, x + width, y + height, paint, [](double, double) { return true; });
}

void Canvas::disc(double x, double y, double radius, const Paint& paint) {
  paint_box(x - radius, y - radius, x + radius, y + radius, paint, [&](double px, double py) {
    return (px - x) * (px - x) + (py - y) * (py - y) <= radius * radius;
  });
}

void Canvas::stroke(double x0, double y0, double x1, double y1, double width, const Paint& paint) {
  const double dx = x1 - x0;
  const double dy = y1 - y0;
  const double length2 = std::max(dx * dx + dy * dy, 1e-12);
  const double reach = 0.5 * width;
  paint_box(std::min(x0, x1) - reach, std::min(y0, y1) - reach, std::max(x0, x1) + reach,
            std::max(y0, y1) + reach, paint, [&](double px, double py) {
              const double along = std::clamp(((px - x0) * dx + (py - y0) * dy) / length2, 0.0, 1.0);
              const double ex = px - x0 - along * dx;
              const double ey = py - y0 - along * dy;
              return ex * ex + ey * ey <= reach * reach;
            });
}

void Canvas::mottle(Random& random, double amplitude, int coarsest, int finest, double persistence) {
  std::vector<float> noise(texels_.size(), 0.0F);
  auto weight = static_cast<float>(amplitude);
  for (int octave = coarsest; octave <= finest && (1 << octave) <= side_; ++octave) {
    const int cells = 1 << octave;
    const int cell = side_ / cells;
    std::vector<float> lattice(static_cast<std::size_t>(cells * cells));
    for (float& value : lattice) value = weight * static_cast<float>(random.uniform(-1.0, 1.0));
    const auto node = [&](int i, int j) {
      return lattice[static_cast<std::size_t>((j & (cells - 1)) * cells + (i & (cells - 1)))];
    };
    for (int row = 0; row < side_; ++row) {
      const int j = row / cell;
      const float t = static_cast<float>(row % cell) / static_cast<float>(cell);
      for (int i = 0; i < cells; ++i) {
        const float left = node(i, j) + t * (node(i, j + 1) - node(i, j));
        const float right = node(i + 1, j) + t * (node(i + 1, j + 1) - node(i + 1, j));
        float* out = &noise[static_cast<std::size_t>(row * side_ + i * cell)];
        const float step = (right - left) / static_cast<float>(cell);
        for (int k = 0; k < cell; ++k) out[k] += left + step * static_cast<float>(k);
      }
    }
    weight *= static_cast<float>(persistence);
  }
  for (std::size_t i = 0; i < texels_.size(); ++i) {
    const float factor = std::max(0.0F, 1.0F + noise[i]);
    texels_[i].r *= factor;
    texels_[i].g *= factor;
    texels_[i].b *= factor;
  }
}

void Canvas::speckle(Random& random, int count, double smallest, double largest, double darkest,
                     double lightest) {
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0.0, 1.0);
    const double y = random.uniform(0.0, 1.0);
    const double share = random.uniform(0.0, 1.0);
    const double radius = smallest + (largest - smallest) * share * share;
    const Paint below = at(static_cast<int>(x * side_), static_cast<int>(y * side_));
    disc(x, y, radius, scaled(below, random.uniform(darkest, lightest)));
  }
}

void Canvas::masonry(Random& random, int columns, int rows, double joint, const Paint& stone,
                     const Paint& mortar, double contrast, bool shifted) {
  fill(mortar);
  const double width = 1.0 / columns;
  const double height = 1.0 / rows;
  for (int row = 0; row < rows; ++row) {
    const double shift = shifted && row % 2 == 1 ? 0.5 * width : 0.0;
    for (int column = 0; column < columns; ++column) {
      rectangle(column * width + shift, row * height, width - joint, height - joint,
                scaled(stone, random.uniform(1.0 - contrast, 1.0 + contrast)));
    }
  }
}

std::vector<std::uint8_t> Canvas::rgb() const {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * texels_.size());
  const auto byte = [](float value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 255.0F)));
  };
  for (const Paint& texel : texels_) {
    bytes.push_back(byte(texel.r));
    bytes.push_back(byte(texel.g));
    bytes.push_back(byte(texel.b));
  }
  return bytes;
}

}  // namespace covey::sim
