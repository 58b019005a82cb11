// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Small worlds whose pictures can be predicted, and the rigs that look at them.

#include <array>
#include <cmath>

#include "core/geometry/rig.h"
#include "core/sim/mesh_builder.h"

namespace covey::sim {

// A chessboard of `squares` x `squares` on the plane through `centre_W` that is turned by R_W_P from x right, y down; its side is
// `side_m`.
struct Chessboard {
  SE3 T_W_P;
  double side_m = 2.0;
  int squares = 8;

  // Inner corner (i, j), 1 ... squares - 1 each.
  Eigen::Vector3d corner(int i, int j) const {
    const double step = side_m / squares;
    return T_W_P * Eigen::Vector3d(i * step - 0.5 * side_m, j * step - 0.5 * side_m, 0.0);
  }
};

inline MeshWorld chessboard_world(const Chessboard& board, Label label) {
  MeshBuilder builder("chessboard", 256);
  Canvas canvas(256);
  canvas.fill({210.0F, 210.0F, 210.0F});
  const double square = 1.0 / board.squares;
  for (int row = 0; row < board.squares; ++row) {
    for (int column = row % 2; column < board.squares; column += 2) {
      canvas.rectangle(column * square, row * square, square, square, {40.0F, 40.0F, 40.0F});
    }
  }
  const int layer = builder.add_texture(canvas);
  const double half = 0.5 * board.side_m;
  const auto at = [&](double x, double y) {
    return Eigen::Vector3d(board.T_W_P * Eigen::Vector3d(x, y, 0.0));
  };
  builder.quad({at(-half, -half), at(-half, half), at(half, half), at(half, -half)}, Patch{}, {layer, label});
  return builder.world();
}

// EuRoC's left lens twice, 0.1 m apart, and a depth camera; all look along z of the body.
inline Rig lens_rig() {
  Rig rig;
  rig.left.camera = {
      752, 480, 458.654, 457.296, 367.215, 248.375, {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
  rig.right = rig.left;
  rig.right->T_B_C.translation = {0.1, 0.0, 0.0};
  rig.depth = DepthCamera{{376, 240, 229.0, 229.0, 187.5, 119.5}, {}, 0.3, 30.0};
  return rig;
}

}  // namespace covey::sim
