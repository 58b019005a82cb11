// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/marching_cubes.h"

#include <catch2/catch.hpp>

#include "tests/core/mesh/analytic_scene.h"

using namespace covey;
using namespace covey::mesh;

namespace {

const Eigen::Vector3d kCentre(0.13, -0.21, 0.07);
constexpr double kRadius = 1.1;

TsdfVolume sphere_from_all_sides(double voxel_m) {
  const DepthCamera camera = make_depth_camera();
  TsdfVolume volume({.voxel_m = voxel_m});
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const SE3 T_O_C = look_at(kCentre + 5.0 * Eigen::Vector3d(x, y, z).normalized(), kCentre);
        volume.integrate(render(camera, T_O_C, sphere(kCentre, kRadius)), camera, T_O_C, 0);
      }
    }
  }
  return volume;
}

}  // namespace

TEST_CASE("A sphere is watertight across blocks, has Euler characteristic 2 and looks outwards") {
  const TsdfVolume volume = sphere_from_all_sides(0.1);
  CHECK(volume.blocks().size() > 27);
  const JoinedMesh mesh = join(volume);
  const auto edges = mesh.directed_edges();
  int open = 0;
  for (const auto& [edge, count] : edges) {
    if (count != 1 || edges.count({edge.second, edge.first}) != 1) ++open;
  }
  CHECK(open == 0);
  const auto vertices = static_cast<int>(mesh.vertices.size());
  CHECK(vertices - static_cast<int>(edges.size() / 2) + static_cast<int>(mesh.faces.size()) == 2);
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f a = mesh.vertices[static_cast<std::size_t>(face[0])];
    const Eigen::Vector3f b = mesh.vertices[static_cast<std::size_t>(face[1])];
    const Eigen::Vector3f c = mesh.vertices[static_cast<std::size_t>(face[2])];
    const Eigen::Vector3f outwards = (a + b + c) / 3.0F - kCentre.cast<float>();
    CHECK((b - a).cross(c - a).dot(outwards) > 0.0F);
  }
}

TEST_CASE("Vertices of a sphere lie on it within a tenth of a voxel, rms") {
  const JoinedMesh mesh = join(sphere_from_all_sides(0.1));
  REQUIRE(mesh.vertices.size() > 1000);
  double squares = 0.0;
  double worst = 0.0;
  for (const auto& p : mesh.vertices) {
    const double error = (p.cast<double>() - kCentre).norm() - kRadius;
    squares += error * error;
    worst = std::max(worst, std::abs(error));
  }
  CHECK(std::sqrt(squares / static_cast<double>(mesh.vertices.size())) < 0.1 * 0.1);
  CHECK(worst < 0.4 * 0.1);
}

TEST_CASE("Blocks share their vertices inside and say which block they are") {
  const TsdfVolume volume = sphere_from_all_sides(0.1);
  for (const auto& block : volume.blocks()) {
    const mesh_block_t part = extract_block(volume, block->index, {});
    CHECK(BlockIndex{part.x, part.y, part.z} == block->index);
    CHECK(part.n_values == 3 * part.n_vertices);
    std::set<std::array<float, 3>> places;
    std::set<int> used(part.corners.begin(), part.corners.end());
    for (std::size_t i = 0; i < part.labels.size(); ++i)
      places.insert({part.p_O[3 * i], part.p_O[3 * i + 1], part.p_O[3 * i + 2]});
    CHECK(places.size() == part.labels.size());
    CHECK(used.size() == part.labels.size());
  }
  const mesh_block_t nothing = extract_block(volume, {100, 0, 0}, {});
  CHECK(nothing.n_vertices == 0);
  CHECK(nothing.n_corners == 0);
}

TEST_CASE("The border between free space and what is hidden is no surface") {
  // A ball before a wall: around its silhouette free voxels have hidden ones beside them.
  const DepthCamera camera = make_depth_camera();
  const SE3 T_O_C = look_at({0, 0, 0}, {1, 0, 0});
  const Surface ball = sphere({2.5, 0, 0}, 0.5);
  const Surface wall = plane(Eigen::Vector3d::UnitX(), 5.0);
  TsdfVolume volume({.voxel_m = 0.05});
  const depth_t image = render(camera, T_O_C, [&](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
    const double to_ball = ball(p_O, n_O);
    return to_ball > 0.0 ? to_ball : wall(p_O, n_O);
  });
  for (int i = 0; i < 3; ++i) volume.integrate(image, camera, T_O_C, 0);
  const JoinedMesh mesh = join(volume);
  int far_from_both = 0;
  for (const auto& p : mesh.vertices) {
    const double to_ball = std::abs((p.cast<double>() - Eigen::Vector3d(2.5, 0, 0)).norm() - 0.5);
    if (std::min(to_ball, std::abs(p.x() - 5.0)) > 0.05) ++far_from_both;
  }
  REQUIRE(mesh.vertices.size() > 1000);
  CHECK(far_from_both < static_cast<int>(mesh.vertices.size() / 100));
}
