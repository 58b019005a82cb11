// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Depth images of analytic shapes, exact but for the rounding to millimetres, and meshes put together from blocks.

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <vector>

#include "core/mesh/marching_cubes.h"

namespace covey::mesh {

inline DepthCamera make_depth_camera(int width = 188, int height = 120) {
  DepthCamera camera;
  camera.camera.width = width;
  camera.camera.height = height;
  camera.camera.fx = camera.camera.fy = 229.0 * width / 376.0;
  camera.camera.cx = 0.5 * (width - 1);
  camera.camera.cy = 0.5 * (height - 1);
  camera.near_m = 0.3;
  camera.far_m = 12.0;
  return camera;
}

// How far along the ray from p_O in direction n_O the surface is; not positive: nowhere.
using Surface = std::function<double(const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O)>;

inline Surface sphere(const Eigen::Vector3d& centre_O, double radius) {
  return [=](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
    const Eigen::Vector3d to_centre = centre_O - p_O;
    const double along = to_centre.dot(n_O);
    const double rest = radius * radius - to_centre.squaredNorm() + along * along;
    return rest < 0.0 ? -1.0 : along - std::sqrt(rest);
  };
}

// normal . p = offset
inline Surface plane(const Eigen::Vector3d& normal_O, double offset) {
  return [=](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
    return (offset - normal_O.dot(p_O)) / normal_O.dot(n_O);
  };
}

inline depth_t render(const DepthCamera& depth_camera, const SE3& T_O_C, const Surface& surface,
                      Utime utime = 1) {
  const PinholeCamera& camera = depth_camera.camera;
  depth_t image{};
  image.utime = utime;
  image.width = camera.width;
  image.height = camera.height;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray_C =
          Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0).normalized();
      const double z = surface(T_O_C.translation, T_O_C.rotation * ray_C) * ray_C.z();
      image.depth_mm.push_back(z > 0.0 && z < 32.0 ? static_cast<std::int16_t>(std::lround(1000.0 * z)) : 0);
    }
  }
  image.n_depth = static_cast<std::int32_t>(image.depth_mm.size());
  return image;
}

// A camera at `from` that looks at `at`, its x level.
inline SE3 look_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
  const Eigen::Vector3d z = (at - from).normalized();
  const Eigen::Vector3d up = std::abs(z.z()) > 0.99 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d x = z.cross(up).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {SO3::from_matrix(R), from};
}

// Vertices at the same place in several blocks are one vertex.
struct JoinedMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<int, 3>> faces;
  std::vector<std::uint8_t> labels;
  std::vector<std::int32_t> keyframes;

  // How many faces each pair of vertices, from first to second, is an edge of.
  std::map<std::pair<int, int>, int> directed_edges() const {
    std::map<std::pair<int, int>, int> edges;
    for (const auto& face : faces) {
      for (std::size_t i = 0; i < 3; ++i) ++edges[{face[i], face[(i + 1) % 3]}];
    }
    return edges;
  }
};

inline JoinedMesh join(const TsdfVolume& volume, const SurfaceOptions& options = {}) {
  JoinedMesh mesh;
  std::map<std::array<float, 3>, int> numbers;
  for (const auto& block : volume.blocks()) {
    const mesh_block_t part = extract_block(volume, block->index, options);
    std::vector<int> number_of;
    for (std::size_t i = 0; i < part.labels.size(); ++i) {
      const std::array<float, 3> p = {part.p_O[3 * i], part.p_O[3 * i + 1], part.p_O[3 * i + 2]};
      const auto [place, is_new] = numbers.try_emplace(p, static_cast<int>(mesh.vertices.size()));
      if (is_new) {
        mesh.vertices.emplace_back(p[0], p[1], p[2]);
        mesh.labels.push_back(part.labels[i]);
        mesh.keyframes.push_back(part.keyframes[i]);
      }
      number_of.push_back(place->second);
    }
    for (std::size_t i = 0; i < part.corners.size(); i += 3) {
      mesh.faces.push_back({number_of[static_cast<std::size_t>(part.corners[i])],
                            number_of[static_cast<std::size_t>(part.corners[i + 1])],
                            number_of[static_cast<std::size_t>(part.corners[i + 2])]});
    }
  }
  return mesh;
}

}  // namespace covey::mesh
