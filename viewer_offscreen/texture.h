// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Textures of one size that a mesh's vertices name by number. They repeat: (u, v) and (u + 1, v) are the same texel. u runs along a
// row, v downwards; (0, 0) is the outer corner of the first texel.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "viewer_offscreen/colour.h"

namespace covey::viewer {

struct Textures {
  int side = 0;                   // texels; a power of two
  std::vector<std::uint8_t> rgb;  // layer by layer, row by row: 3 * side * side * layers

  int layers() const {
    return side == 0 ? 0 : static_cast<int>(rgb.size() / (3 * static_cast<std::size_t>(side * side)));
  }
};

// What a vertex of a textured mesh carries.
struct TexturePoint {
  float u = 0.0F;
  float v = 0.0F;
  std::uint16_t layer = 0;     // the same at a face's three corners
  Rgb tint = {255, 255, 255};  // multiplies the texture; 255 leaves it as it is
};

}  // namespace covey::viewer
