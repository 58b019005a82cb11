// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The 256 cases of marching cubes (Lorensen and Cline, SIGGRAPH 1987), derived rather than tabulated.
//
// Corner c of a cell stands at (c & 1, c >> 1 & 1, c >> 2 & 1); edge e runs along axis e / 4, its corners are edge_corners(e). On each
// face the surface runs around each run of inside corners on its own, so that on a face with four crossings (two opposite corners
// inside) inside corners are cut off one by one. That depends on the face's four signs only, so the two cells that share the face agree,
// and the surface is watertight. The segments of the six faces link up to loops, and loops are cut into triangles without any diagonal
// in a face of the cell, where the neighbour could have the same one.

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace covey::mesh {

constexpr int kCubeEdges = 12;

constexpr std::pair<int, int> edge_corners(int edge) {
  const int axis = edge / 4;
  const int b = (axis + 1) % 3;
  const int c = (axis + 2) % 3;
  const int low = ((edge & 1) << b) | ((edge >> 1 & 1) << c);
  return {low, low | 1 << axis};
}

using CubeTriangle = std::array<std::uint8_t, 3>;  // edges, counter-clockwise seen from outside

// Bit c of the case: corner c is inside (its distance is negative).
const std::vector<CubeTriangle>& cube_triangles(int cube_case);

// Of two edges: whether a face of the cell has both.
bool on_one_face(int edge, int other);

}  // namespace covey::mesh
