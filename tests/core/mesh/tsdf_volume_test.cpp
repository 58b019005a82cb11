// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/tsdf_volume.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/core/mesh/analytic_scene.h"

using namespace covey;
using namespace covey::mesh;

namespace {

double rms_height(const JoinedMesh& mesh) {
  double sum = 0.0;
  for (const auto& p : mesh.vertices) sum += static_cast<double>(p.z()) * p.z();
  return std::sqrt(sum / static_cast<double>(mesh.vertices.size()));
}

SE3 above_street(double x) { return look_at({x, 0.03, 0.6}, {x + 5.0, 0.1, 0.4}); }

}  // namespace

TEST_CASE("A street seen at grazing angles becomes a plane within a hundredth of a voxel") {
  const DepthCamera camera = make_depth_camera();
  TsdfVolume volume({.voxel_m = 0.1});
  for (int i = 0; i < 8; ++i) {
    volume.integrate(render(camera, above_street(0.2 * i), plane(Eigen::Vector3d::UnitZ(), 0.0)), camera,
                     above_street(0.2 * i), i);
  }
  const JoinedMesh mesh = join(volume);
  REQUIRE(mesh.vertices.size() > 2000);
  CHECK(rms_height(mesh) < 0.001);
  float farthest = 0.0F;
  for (const auto& p : mesh.vertices) farthest = std::max(farthest, p.x());
  CHECK(farthest > 5.0F);
}

TEST_CASE("What is seen behind a surface does not bend the field before it") {
  // Over a street's far end one sees a wall: rays to it pass closely above the street.
  const DepthCamera camera = make_depth_camera();
  TsdfVolume volume({.voxel_m = 0.1});
  const Surface street = plane(Eigen::Vector3d::UnitZ(), 0.0);
  const Surface wall = plane(Eigen::Vector3d::UnitX(), 8.0);
  for (int i = 0; i < 20; ++i) {
    const SE3 T_O_C = above_street(0.2 * i);
    volume.integrate(render(camera, T_O_C,
                            [&](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
                              const double to_street = street(p_O, n_O);
                              const double to_wall = wall(p_O, n_O);
                              return to_street > 0.0 ? std::min(to_street, to_wall) : to_wall;
                            }),
                     camera, T_O_C, i);
  }
  double worst = 0.0;
  int voxels = 0;
  for (int x = 20; x < 50; ++x) {
    const Block* block = volume.find({x / kBlockSide, 0, 0});
    REQUIRE(block != nullptr);
    for (int z = 0; z <= 1; ++z) {
      const Voxel& voxel = block->voxels[static_cast<std::size_t>(voxel_number(x % kBlockSide, 0, z))];
      if (voxel.weight == 0.0F) continue;
      ++voxels;
      worst = std::max(worst, std::abs(voxel.distance - 0.1 * z));
    }
  }
  CHECK(voxels > 55);
  CHECK(worst < 0.02);
}

TEST_CASE("Noise in the depths averages out") {
  const DepthCamera camera = make_depth_camera();
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 0.002);  // of the inverse depth: 18 mm at 3 m
  TsdfVolume once({.voxel_m = 0.1});
  TsdfVolume often({.voxel_m = 0.1});
  const SE3 T_O_C = look_at({0, 0, 3.0}, {0.3, 0.2, 0.0});
  for (int i = 0; i < 25; ++i) {
    depth_t image = render(camera, T_O_C, plane(Eigen::Vector3d::UnitZ(), 0.0));
    for (auto& depth : image.depth_mm) {
      if (depth > 0) depth = static_cast<std::int16_t>(1000.0 / (1000.0 / depth + noise(random)));
    }
    if (i == 0) once.integrate(image, camera, T_O_C, 0);
    often.integrate(image, camera, T_O_C, 0);
  }
  const double rms_once = rms_height(join(once));
  const double rms_often = rms_height(join(often));
  CHECK(rms_once < 0.025);
  CHECK(rms_often < 0.35 * rms_once);  // 1/5 for independent noise, but neighbours share pixels
  CHECK(rms_often > 0.0);
}

TEST_CASE("What was there and is gone is carved away") {
  const DepthCamera camera = make_depth_camera();
  const SE3 T_O_C = look_at({0, 0, 0}, {1, 0, 0});
  const Surface wall = plane(Eigen::Vector3d::UnitX(), 5.0);
  const Surface ball = sphere({2.5, 0, 0}, 0.4);
  const Surface both = [=](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
    const double to_ball = ball(p_O, n_O);
    return to_ball > 0.0 ? to_ball : wall(p_O, n_O);
  };
  const auto vertices_before_wall = [](const TsdfVolume& volume) {
    int count = 0;
    for (const auto& p : join(volume).vertices) count += p.x() < 4.0F ? 1 : 0;
    return count;
  };
  TsdfVolume volume({.voxel_m = 0.1});
  volume.integrate(render(camera, T_O_C, both), camera, T_O_C, 0);
  CHECK(vertices_before_wall(volume) > 50);
  // Weights are 1/z^2: the ball at 2.1 m weighs six times as much as the wall behind it, but a ray that passes counts ten times.
  for (int i = 0; i < 5; ++i) volume.integrate(render(camera, T_O_C, wall), camera, T_O_C, 0);
  CHECK(vertices_before_wall(volume) == 0);
}

TEST_CASE("Labels, colours and keyframes reach the vertices") {
  const DepthCamera camera = make_depth_camera();
  const SE3 T_O_C = look_at({0, 0, 0}, {1, 0, 0});
  depth_t image = render(camera, T_O_C, plane(Eigen::Vector3d::UnitX(), 3.0));
  const std::size_t pixels = image.depth_mm.size();
  image.n_labels = image.n_depth;
  image.n_colours = 3 * image.n_depth;
  for (std::size_t i = 0; i < pixels; ++i) image.colours.insert(image.colours.end(), {200, 100, 50});
  TsdfVolume volume({.voxel_m = 0.1});
  const auto add = [&](std::uint8_t label, int keyframe) {
    image.labels.assign(pixels, label);
    volume.integrate(image, camera, T_O_C, keyframe);
  };
  add(4, 0);
  add(9, 1);
  add(9, 2);
  add(kUnknownLabel, 2);
  add(kUnknownLabel, 2);
  add(kUnknownLabel, 2);
  const mesh_block_t block = extract_block(volume, {3, 0, 0}, {});
  REQUIRE(block.n_vertices > 20);
  REQUIRE(block.colours.size() == static_cast<std::size_t>(3 * block.n_vertices));
  for (std::size_t i = 0; i < block.labels.size(); ++i) {
    CHECK(block.labels[i] == 9);
    CHECK(block.keyframes[i] == 2);
    CHECK(block.colours[3 * i] == 200);
    CHECK(block.colours[3 * i + 1] == 100);
    CHECK(block.colours[3 * i + 2] == 50);
  }
}

TEST_CASE("A vertex whose label is as likely wrong as right is unknown") {
  const DepthCamera camera = make_depth_camera();
  const SE3 T_O_C = look_at({0, 0, 0}, {1, 0, 0});
  depth_t image = render(camera, T_O_C, plane(Eigen::Vector3d::UnitX(), 3.0));
  image.n_labels = image.n_depth;
  TsdfVolume volume({.voxel_m = 0.1});
  for (const int label : {4, 9}) {
    image.labels.assign(image.depth_mm.size(), static_cast<std::uint8_t>(label));
    volume.integrate(image, camera, T_O_C, 0);
  }
  const mesh_block_t block = extract_block(volume, {3, 0, 0}, {});
  REQUIRE(block.n_vertices > 20);
  for (const std::uint8_t label : block.labels) CHECK(label == kUnknownLabel);
}

TEST_CASE("Only blocks in view near a surface change") {
  const DepthCamera camera = make_depth_camera();
  TsdfVolume volume({.voxel_m = 0.1});
  const Surface walls = [](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
    return plane(Eigen::Vector3d::UnitX(), n_O.x() > 0.0 ? 4.0 : -4.0)(p_O, n_O);
  };
  const SE3 ahead = look_at({0, 0, 0}, {1, 0, 0});
  const SE3 back = look_at({0, 0, 0}, {-1, 0, 0});
  const Integration first = volume.integrate(render(camera, ahead, walls), camera, ahead, 0);
  CHECK(first.new_blocks > 0);
  CHECK(10 * first.changed.size() > 9 * volume.blocks().size());  // some are just out of view
  const Integration second = volume.integrate(render(camera, back, walls), camera, back, 0);
  for (const BlockIndex& index : second.changed) CHECK(index.x < 0);
  const Integration third = volume.integrate(render(camera, ahead, walls), camera, ahead, 0);
  CHECK(third.new_blocks == 0);
  for (const BlockIndex& index : third.changed) CHECK(index.x >= 0);

  // Cells reach into the next block: the block before a changed one is extracted again.
  const std::vector<BlockIndex> indices = blocks_to_extract(volume, {{5, 0, 0}, {4, 0, 0}});
  CHECK(std::find(indices.begin(), indices.end(), BlockIndex{4, -1, -1}) != indices.end());
  CHECK(std::find(indices.begin(), indices.end(), BlockIndex{4, 1, 0}) == indices.end());
  CHECK(std::is_sorted(indices.begin(), indices.end()));
  CHECK(std::adjacent_find(indices.begin(), indices.end()) == indices.end());
}

TEST_CASE("Memory is bounded by forgetting what was not seen for longest") {
  const DepthCamera camera = make_depth_camera();
  TsdfVolume volume({.voxel_m = 0.1, .memory_mb = 3.0});
  int forgotten = 0;
  for (int i = 0; i < 40; ++i) {
    const SE3 T_O_C = above_street(0.5 * i);
    forgotten += volume
                     .integrate(render(camera, T_O_C, plane(Eigen::Vector3d::UnitZ(), 0.0), 1000 * i), camera,
                                T_O_C, i)
                     .forgotten_blocks;
    CHECK(volume.bytes() <= 3'000'000);
  }
  CHECK(forgotten > 0);
  CHECK(volume.find({0, 0, 0}) == nullptr);
  CHECK(volume.find({26, 0, 0}) != nullptr);
}

TEST_CASE("The same images make the same volume to the last bit") {
  const DepthCamera camera = make_depth_camera();
  std::array<JoinedMesh, 2> meshes;
  for (JoinedMesh& mesh : meshes) {
    TsdfVolume volume({.voxel_m = 0.1, .memory_mb = 3.0});
    for (int i = 0; i < 30; ++i) {
      const SE3 T_O_C = above_street(0.5 * i);
      volume.integrate(render(camera, T_O_C, plane(Eigen::Vector3d(0, 0.1, 1).normalized(), 0.0)), camera,
                       T_O_C, i);
    }
    mesh = join(volume);
  }
  REQUIRE(meshes[0].vertices.size() > 100);
  CHECK(meshes[0].vertices == meshes[1].vertices);
  CHECK(meshes[0].faces == meshes[1].faces);
  CHECK(meshes[0].keyframes == meshes[1].keyframes);
}
