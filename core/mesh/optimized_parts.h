// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A deformed mesh as messages (MESH_OPTIMIZED), each with vertices and faces of its own: a vertex that faces of several parts
// share stands in each of them.

#include <covey/mesh_optimized_t.hpp>
#include <span>
#include <vector>

#include "core/mesh/robot_mesh.h"

namespace covey::mesh {

constexpr int kVerticesPerPart = 1500;

// What all parts have in common is in `name`: utime, robot, anchor, round. Vertices that no face has are left out.
std::vector<mesh_optimized_t> optimized_parts(const mesh_optimized_t& name, const MeshSnapshot& snapshot,
                                              std::span<const Eigen::Vector3f> p_W);

}  // namespace covey::mesh
