// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Meshes of plane pieces for tests of what measures meshes.

#include <functional>

#include "viewer_offscreen/mesh.h"

namespace covey::testing {

using Place = std::function<Eigen::Vector3d(double u, double v)>;
using LabelAt = std::function<int(double u, double v)>;

// A grid of squares of `step` over [0, width] x [0, height], put in place; labels by the squares' lower corners.
inline viewer::Mesh make_plane(
    double width, double height, double step, const Place& place,
    const LabelAt& label = [](double, double) { return 1; }) {
  viewer::Mesh mesh;
  const int columns = static_cast<int>(width / step + 0.5);
  const int rows = static_cast<int>(height / step + 0.5);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (const auto& [du, dv] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{1, 1}, std::pair{0, 1}}) {
        mesh.vertices.push_back(place(step * (i + du), step * (j + dv)).cast<float>());
        mesh.labels.push_back(static_cast<std::uint16_t>(label(step * i, step * j)));
        mesh.colours.push_back({100, 150, 200});
      }
      mesh.faces.push_back({first, first + 1, first + 2});
      mesh.faces.push_back({first, first + 2, first + 3});
    }
  }
  return mesh;
}

inline viewer::Mesh joined(const viewer::Mesh& a, const viewer::Mesh& b) {
  viewer::Mesh mesh = a;
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), b.vertices.begin(), b.vertices.end());
  mesh.labels.insert(mesh.labels.end(), b.labels.begin(), b.labels.end());
  mesh.colours.insert(mesh.colours.end(), b.colours.begin(), b.colours.end());
  for (const auto& [i, j, k] : b.faces) mesh.faces.push_back({first + i, first + j, first + k});
  return mesh;
}

}  // namespace covey::testing
