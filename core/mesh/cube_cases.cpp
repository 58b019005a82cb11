// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/cube_cases.h"

#include <optional>

#include "core/base/error.h"

namespace covey::mesh {
namespace {

using Loop = std::vector<int>;

int edge_between(int corner, int other) {
  for (int edge = 0; edge < kCubeEdges; ++edge) {
    const auto [low, high] = edge_corners(edge);
    if ((low == corner && high == other) || (low == other && high == corner)) return edge;
  }
  COVEY_CHECK(false);
}

// Counter-clockwise seen from outside of the cell.
std::array<int, 4> face_corners(int face) {
  const int axis = face / 2;
  const int b = 1 << (axis + 1) % 3;
  const int c = 1 << (axis + 2) % 3;
  if (face % 2 == 0) return {0, c, b | c, b};
  const int a = 1 << axis;
  return {a, a | b, a | b | c, a | c};
}

// next[e]: the edge to which the surface goes on from edge e; -1 where it does not cross e.
std::array<int, kCubeEdges> link_segments(int cube_case) {
  std::array<int, kCubeEdges> next;
  next.fill(-1);
  const auto inside = [cube_case](int corner) { return (cube_case >> corner & 1) != 0; };
  for (int face = 0; face < 6; ++face) {
    const std::array<int, 4> corners = face_corners(face);
    for (std::size_t begin = 0; begin < 4; ++begin) {
      const int outside = corners[begin];
      if (inside(outside) || !inside(corners[(begin + 1) % 4])) continue;
      std::size_t end = begin + 1;
      while (inside(corners[(end + 1) % 4])) ++end;
      next[static_cast<std::size_t>(edge_between(outside, corners[(begin + 1) % 4]))] =
          edge_between(corners[end % 4], corners[(end + 1) % 4]);
    }
  }
  return next;
}

// Of loop[first ... last], whose sides may all lie in faces but the diagonals not; none where there is no such way.
std::optional<std::vector<CubeTriangle>> cut(const Loop& loop, std::size_t first, std::size_t last) {
  if (last - first < 2) return std::vector<CubeTriangle>{};
  const auto side_is_good = [&](std::size_t i, std::size_t j) {
    return j - i == 1 || !on_one_face(loop[i], loop[j]);
  };
  for (std::size_t apex = first + 1; apex < last; ++apex) {
    if (!side_is_good(first, apex) || !side_is_good(apex, last)) continue;
    auto before = cut(loop, first, apex);
    auto after = cut(loop, apex, last);
    if (!before || !after) continue;
    before->push_back({static_cast<std::uint8_t>(loop[first]), static_cast<std::uint8_t>(loop[apex]),
                       static_cast<std::uint8_t>(loop[last])});
    before->insert(before->end(), after->begin(), after->end());
    return before;
  }
  return std::nullopt;
}

std::vector<CubeTriangle> triangles_of(int cube_case) {
  std::array<int, kCubeEdges> next = link_segments(cube_case);
  std::vector<CubeTriangle> triangles;
  for (int start = 0; start < kCubeEdges; ++start) {
    Loop loop;
    for (int edge = start; next[static_cast<std::size_t>(edge)] >= 0;) {
      loop.push_back(edge);
      edge = std::exchange(next[static_cast<std::size_t>(edge)], -1);
    }
    if (loop.empty()) continue;
    const auto cut_loop = cut(loop, 0, loop.size() - 1);
    COVEY_CHECK(cut_loop.has_value());
    triangles.insert(triangles.end(), cut_loop->begin(), cut_loop->end());
  }
  return triangles;
}

std::array<std::vector<CubeTriangle>, 256> all_cases() {
  std::array<std::vector<CubeTriangle>, 256> cases;
  for (int i = 0; i < 256; ++i) cases[static_cast<std::size_t>(i)] = triangles_of(i);
  return cases;
}

}  // namespace

bool on_one_face(int edge, int other) {
  const auto [low, high] = edge_corners(edge);
  const auto [other_low, other_high] = edge_corners(other);
  const int all_set = low & high & other_low & other_high;  // in the face at 1 of some axis
  const int any_set = low | high | other_low | other_high;  // else in the one at 0
  return all_set != 0 || any_set != 7;
}

const std::vector<CubeTriangle>& cube_triangles(int cube_case) {
  static const std::array<std::vector<CubeTriangle>, 256> kCases = all_cases();
  return kCases[static_cast<std::size_t>(cube_case)];
}

}  // namespace covey::mesh
