// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The surfaces of the simulated worlds, painted from a seed: each has structure from its full side down to a few texels, so that corners
// are found in it from any distance. What length a texture's side stands for is said with each.

#include "core/sim/canvas.h"

namespace covey::sim {

Canvas paint_asphalt(int side, Random& random);    // 4 m: gravel, patches, cracks
Canvas paint_grass(int side, Random& random);      // 3 m
Canvas paint_paving(int side, Random& random);     // 3 m: slabs
Canvas paint_roof(int side, Random& random);       // 3 m: tiles
Canvas paint_leaves(int side, Random& random);     // 1.5 m
Canvas paint_bark(int side, Random& random);       // 0.7 m
Canvas paint_planks(int side, Random& random);     // 1.8 m: upright boards
Canvas paint_steel(int side, Random& random);      // 1 m: bands, rust and stickers
Canvas paint_bodywork(int side, Random& random);   // 2.5 m: doors, lettering, dirt
Canvas paint_tyre(int side, Random& random);       // the whole wheel in a square
Canvas paint_glass(int side, Random& random);      // 1.5 m: reflections
Canvas paint_parquet(int side, Random& random);    // 2 m
Canvas paint_wallpaper(int side, Random& random);  // 2.5 m
Canvas paint_wood(int side, Random& random);       // 1 m: grain and knots
Canvas paint_carton(int side, Random& random);     // one side of a box: tape, labels, marks
Canvas paint_books(int side, Random& random);      // 1.2 m: three rows of spines
Canvas paint_tiles(int side, Random& random);      // 2 m: ceiling panels

// A wall of one house, one storey high or two: masonry or plaster, windows with frames and curtains, pipes, stains, lettering.
struct Facade {
  int storeys = 2;
  int windows = 3;  // in a row
  bool has_door = true;
};
Canvas paint_facade(int side, Random& random, const Facade& facade);

// A sheet of pictures, all different, and where on it number 0 ... kPostersOnSheet - 1 is.
constexpr int kPostersOnSheet = 16;
Canvas paint_posters(int side, Random& random);
Patch poster_patch(int number);

}  // namespace covey::sim
