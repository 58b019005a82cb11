// SPDX-License-Identifier: BSD-3-Clause
// Time of the volume's parts for one depth image of 376 x 240: a street (voxels of 0.15 and 0.10 m, to 12 m) and a room (0.05 m). The
// camera moves on by 0.2 m and 4 degrees from image to image, as at 5 Hz. `mesh` extracts what one image has changed.
#include <benchmark/benchmark.h>

#include "tests/core/mesh/analytic_scene.h"

using namespace covey;
using namespace covey::mesh;

namespace {

Surface inside_of_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return [=](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
    double nearest = 1e3;
    for (int axis = 0; axis < 3; ++axis) {
      const double to = ((n_O[axis] > 0.0 ? high : low)[axis] - p_O[axis]) / n_O[axis];
      nearest = std::min(nearest, to);
    }
    return nearest;
  };
}

struct Walk {
  DepthCamera camera;
  std::vector<depth_t> images;
  std::vector<SE3> poses;
};

Walk walk_through(const Surface& surface, const Eigen::Vector3d& start, double step_m) {
  Walk walk{make_depth_camera(376, 240), {}, {}};
  for (int i = 0; i < 20; ++i) {
    const double yaw = 0.07 * i;
    const Eigen::Vector3d p = start + Eigen::Vector3d(step_m * i, 0, 0);
    walk.poses.push_back(look_at(p, p + Eigen::Vector3d(std::cos(yaw), std::sin(yaw), -0.05)));
    depth_t image = render(walk.camera, walk.poses.back(), surface, 200'000 * i);
    image.labels.assign(image.depth_mm.size(), 3);
    image.colours.assign(3 * image.depth_mm.size(), 90);
    walk.images.push_back(std::move(image));
  }
  return walk;
}

Walk street() { return walk_through(inside_of_box({-20, -5, 0}, {60, 6, 30}), {0, 0, 0.6}, 0.2); }
Walk room() { return walk_through(inside_of_box({-3, -4, 0}, {4, 3, 2.8}), {-1, 0, 1.4}, 0.05); }

void integrate(benchmark::State& state, const Walk& walk, double voxel_m) {
  TsdfVolume volume({.voxel_m = voxel_m});
  std::size_t i = 0;
  int in_view = 0;
  for (auto _ : state) {
    const std::size_t n = i++ % walk.images.size();
    in_view = volume.integrate(walk.images[n], walk.camera, walk.poses[n], 0).blocks_in_view;
  }
  state.counters["blocks_in_view"] = in_view;
  state.counters["MB"] = 1e-6 * static_cast<double>(volume.bytes());
}

void mesh_changes(benchmark::State& state, const Walk& walk, double voxel_m) {
  TsdfVolume volume({.voxel_m = voxel_m});
  std::vector<BlockIndex> changed;
  for (std::size_t i = 0; i < walk.images.size(); ++i)
    changed = volume.integrate(walk.images[i], walk.camera, walk.poses[i], 0).changed;
  std::size_t vertices = 0;
  for (auto _ : state) {
    vertices = 0;
    for (const BlockIndex& index : blocks_to_extract(volume, changed))
      vertices += extract_block(volume, index, {}).labels.size();
  }
  state.counters["blocks"] = static_cast<double>(changed.size());
  state.counters["vertices"] = static_cast<double>(vertices);
}

void tangent_planes(benchmark::State& state) {
  const Walk walk = street();
  TangentPlanes planes;
  for (auto _ : state) planes.compute(walk.images[0], walk.camera);
}
BENCHMARK(tangent_planes)->Unit(benchmark::kMillisecond);

void register_walks() {
  const auto add = [](const std::string& name, auto function, const Walk& walk, double voxel_m) {
    benchmark::RegisterBenchmark(name.c_str(), function, walk, voxel_m)->Unit(benchmark::kMillisecond);
  };
  add("integrate/street_0.15", integrate, street(), 0.15);
  add("integrate/street_0.10", integrate, street(), 0.10);
  add("integrate/room_0.05", integrate, room(), 0.05);
  add("mesh/street_0.15", mesh_changes, street(), 0.15);
  add("mesh/street_0.10", mesh_changes, street(), 0.10);
  add("mesh/room_0.05", mesh_changes, room(), 0.05);
}

const bool kRegistered = (register_walks(), true);

}  // namespace
