// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/mesh.h"

#include <Eigen/Geometry>

namespace covey::viewer {

std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh) {
  std::vector<Eigen::Vector3f> normals(mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const auto& [a, b, c] : mesh.faces) {
    const Eigen::Vector3f& p_a = mesh.vertices[a];
    // The cross product's length is twice the area: the weight comes with it.
    const Eigen::Vector3f normal = (mesh.vertices[b] - p_a).cross(mesh.vertices[c] - p_a);
    for (const std::uint32_t corner : {a, b, c}) normals[corner] += normal;
  }
  for (Eigen::Vector3f& normal : normals) normal.normalize();
  return normals;
}

}  // namespace covey::viewer
