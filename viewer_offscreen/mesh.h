// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A triangle mesh as it is drawn and as it stands in a PLY file: shared vertices, optionally with a colour
// and a semantic label each. Corners run counter-clockwise seen from the free side, the side a camera can be
// on.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "viewer_offscreen/colour.h"
#include "viewer_offscreen/texture.h"

namespace covey::viewer {

// "No label", in meshes and in rendered label images.
constexpr std::uint16_t kNoLabel = 0xFFFF;
// Robots say a label in a byte, and 255 is none: in their meshes it stands for kNoLabel.
constexpr std::uint16_t kFirstNoLabel = 255;

struct Mesh {
  std::vector<Eigen::Vector3f> vertices;            // metres
  std::vector<Rgb> colours;                         // one per vertex, or empty
  std::vector<std::uint16_t> labels;                // one per vertex, or empty
  std::vector<std::array<std::uint32_t, 3>> faces;  // indices of vertices
  std::vector<TexturePoint> texture = {};           // one per vertex, or empty; not in PLY files
};

// Unit normals per vertex, each face weighing by its area; zero where a vertex has no face.
std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh);

}  // namespace covey::viewer
