// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A picture in memory: rows from the top, pixels from the left, three bytes red, green, blue each.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "viewer_offscreen/colour.h"

namespace covey::viewer {

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;  // 3 * width * height

  Rgb at(int column, int row) const {
    const std::size_t first = 3 * (static_cast<std::size_t>(row) * width + column);
    return {rgb[first], rgb[first + 1], rgb[first + 2]};
  }
};

}  // namespace covey::viewer
