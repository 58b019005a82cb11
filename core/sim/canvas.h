// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A square texture while it is painted. Coordinates run from 0 to 1, x to the right and y downwards, and wrap: what leaves on one side
// comes in on the other, so that every texture can be repeated.

#include <array>
#include <cstdint>
#include <vector>

#include "core/sim/random.h"

namespace covey::sim {

struct Paint {
  float r = 0.0F;  // 0 ... 255
  float g = 0.0F;
  float b = 0.0F;
};

Paint scaled(const Paint& paint, double factor);
Paint random_paint(Random& random, double darkest, double lightest);

// A part of a texture, in texture coordinates; may go beyond [0, 1], where the texture repeats.
struct Patch {
  double u = 0.0;
  double v = 0.0;
  double width = 1.0;
  double height = 1.0;
};

class Canvas {
 public:
  explicit Canvas(int side);  // texels, a power of two

  void fill(const Paint& paint);
  void rectangle(double x, double y, double width, double height, const Paint& paint);
  void disc(double x, double y, double radius, const Paint& paint);
  void stroke(double x0, double y0, double x1, double y1, double width, const Paint& paint);

  // Multiplies by fractal noise around 1: cells of 1 / 2^coarsest of the side, then of half that, down to 1 / 2^finest, every octave at
  // `persistence` of the one before.
  void mottle(Random& random, double amplitude, int coarsest, int finest, double persistence);
  // Discs of random place, size and brightness over what is there.
  void speckle(Random& random, int count, double smallest, double largest, double darkest, double lightest);

  // Rows of stones of random brightness, `columns` to a row, every other row shifted by half a stone.
  void masonry(Random& random, int columns, int rows, double joint, const Paint& stone, const Paint& mortar,
               double contrast, bool shifted);

  int side() const { return side_; }
  std::vector<std::uint8_t> rgb() const;  // 3 * side * side

 private:
  Paint& at(int column, int row);
  template <typename Inside>
  void paint_box(double x0, double y0, double x1, double y1, const Paint& paint, const Inside& inside);

  int side_;
  std::vector<Paint> texels_;
};

}  // namespace covey::sim
