// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/cube_cases.h"

#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <tuple>

using namespace covey::mesh;

namespace {

// An edge of the lattice: lower end and axis.
using LatticeEdge = std::tuple<int, int, int, int>;

}  // namespace

TEST_CASE("One inside corner is cut off by one triangle that looks away from it") {
  for (int corner = 0; corner < 8; ++corner) {
    const auto& triangles = cube_triangles(1 << corner);
    REQUIRE(triangles.size() == 1);
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = edge_corners(triangles[0][i]);
      for (int axis = 0; axis < 3; ++axis)
        p[i][static_cast<std::size_t>(axis)] = 0.5 * ((low >> axis & 1) + (high >> axis & 1));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t b = (axis + 1) % 3;
      const std::size_t c = (axis + 2) % 3;
      const double normal =
          (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
      CHECK(normal * ((corner >> axis & 1) != 0 ? -1.0 : 1.0) > 0.0);
    }
  }
}

TEST_CASE("Cubes use the edges that change sign and no diagonal lies in a face of the cell") {
  for (int cube_case = 0; cube_case < 256; ++cube_case) {
    std::map<int, int> used;
    std::map<std::pair<int, int>, int> sides;
    for (const CubeTriangle& triangle : cube_triangles(cube_case)) {
      for (std::size_t i = 0; i < 3; ++i) {
        ++used[triangle[i]];
        ++sides[{triangle[i], triangle[(i + 1) % 3]}];
      }
    }
    for (int edge = 0; edge < kCubeEdges; ++edge) {
      const auto [low, high] = edge_corners(edge);
      CHECK((used.count(edge) > 0) == ((cube_case >> low & 1) != (cube_case >> high & 1)));
    }
    for (const auto& [side, count] : sides) {
      CHECK(count == 1);
      if (sides.count({side.second, side.first}) > 0) CHECK_FALSE(on_one_face(side.first, side.second));
    }
  }
}

TEST_CASE("Cells of random signs make a closed surface") {
  constexpr int kSide = 12;
  std::mt19937 random(5);
  for (const unsigned one_in : {2U, 4U}) {
    bool inside[kSide + 1][kSide + 1][kSide + 1] = {};
    for (int x = 1; x < kSide; ++x)
      for (int y = 1; y < kSide; ++y)
        for (int z = 1; z < kSide; ++z) inside[x][y][z] = random() % one_in == 0;
    std::map<std::pair<LatticeEdge, LatticeEdge>, int> sides;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z) {
          int cube_case = 0;
          for (int c = 0; c < 8; ++c)
            cube_case |= inside[x + (c & 1)][y + (c >> 1 & 1)][z + (c >> 2)] ? 1 << c : 0;
          const auto lattice_edge = [&](int edge) {
            const int low = edge_corners(edge).first;
            return LatticeEdge{x + (low & 1), y + (low >> 1 & 1), z + (low >> 2), edge / 4};
          };
          for (const CubeTriangle& t : cube_triangles(cube_case)) {
            for (std::size_t i = 0; i < 3; ++i) ++sides[{lattice_edge(t[i]), lattice_edge(t[(i + 1) % 3])}];
          }
        }
      }
    }
    REQUIRE(sides.size() > 1000);
    int open = 0;
    for (const auto& [side, count] : sides) {
      const auto other = sides.find({side.second, side.first});
      if (count != 1 || other == sides.end() || other->second != 1) ++open;
    }
    CHECK(open == 0);
  }
}
