// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/mapper.h"

#include <catch2/catch.hpp>
#include <map>

#include "core/mesh/keyframe_stamps.h"
#include "tests/core/mesh/analytic_scene.h"

using namespace covey;
using namespace covey::mesh;

namespace {

const Surface kWalls = [](const Eigen::Vector3d& p_O, const Eigen::Vector3d& n_O) {
  return plane(Eigen::Vector3d::UnitX(), n_O.x() > 0.0 ? 4.0 : -4.0)(p_O, n_O);
};
const SE3 kAhead = look_at({0, 0, 0}, {1, 0, 0});
const SE3 kBack = look_at({0, 0, 0}, {-1, 0, 0});

}  // namespace

TEST_CASE("The schedule says a block soon, then ever more rarely, and once more when it rests") {
  MeshSchedule schedule({.period_s = 1.0, .idle_s = 0.5});
  std::vector<double> said_at;
  const auto say = [&](Utime now) {
    if (!schedule.take_due(now).empty()) said_at.push_back(to_seconds(now));
  };
  for (Utime now = 0; now <= 20 * kUsPerSecond; now += 200'000) {
    schedule.on_changed({{1, 2, 3}}, now);
    say(now);
  }
  for (Utime now = 20'200'000; now <= 40 * kUsPerSecond; now += 200'000) say(now);
  // 6 changes at 1 s; 12, 24, 48, 96 at 0.2 s each; the last after 0.5 s without one.
  REQUIRE(said_at.size() == 6);
  CHECK(said_at[0] == Approx(1.0));
  CHECK(said_at[1] == Approx(2.2));
  CHECK(said_at[2] == Approx(4.6));
  CHECK(said_at[4] == Approx(19.0));
  CHECK(said_at[5] == Approx(20.6));
  CHECK(schedule.waiting() == 0);
}

TEST_CASE("A mapper says changed blocks only and ends with the volume as it is") {
  const DepthCamera camera = make_depth_camera();
  Mapper mapper({}, camera);
  std::map<BlockIndex, mesh_block_t> told;
  const auto take = [&](const std::vector<mesh_block_t>& blocks) {
    for (const mesh_block_t& block : blocks) {
      CHECK(block.segment == 7);
      told[{block.x, block.y, block.z}] = block;
    }
    return blocks.size();
  };
  Utime now = 0;
  const auto look = [&](const SE3& T_O_C, int images) {
    std::size_t said = 0;
    for (int i = 0; i < images; ++i) {
      now += 200'000;
      mapper.add(render(camera, T_O_C, kWalls, now), 7, T_O_C * camera.T_B_C.inverse(), 0);
      said += take(mapper.take_due());
    }
    return said;
  };
  look(kAhead, 20);
  const std::size_t ahead = told.size();
  CHECK(ahead > 20);
  for (const auto& [index, block] : told) CHECK(block.n_vertices > 0);
  look(kBack, 20);
  CHECK(told.size() > ahead + 20);
  take(mapper.take_all());
  CHECK(mapper.take_all().empty());
  // The wall ahead has rested for long, and looking at it once more from where it was seen does not move it.
  std::size_t vertices = 0;
  for (const auto& block : mapper.volume()->blocks())
    vertices += extract_block(*mapper.volume(), block->index, {}).labels.size();
  std::size_t told_vertices = 0;
  for (const auto& [index, block] : told) told_vertices += block.labels.size();
  CHECK(told_vertices == vertices);
}

TEST_CASE("What disappears is said as an empty block") {
  const DepthCamera camera = make_depth_camera();
  const Surface near_wall = plane(Eigen::Vector3d::UnitX(), 2.0);
  Mapper mapper({}, camera);
  Utime now = 0;
  mapper.add(render(camera, kAhead, near_wall, ++now), 1, kAhead, 0);
  std::map<BlockIndex, int> vertices;
  const auto take = [&] {
    for (const mesh_block_t& block : mapper.take_all())
      vertices[{block.x, block.y, block.z}] = block.n_vertices;
  };
  take();
  REQUIRE(vertices.size() > 4);
  for (int i = 0; i < 60; ++i) mapper.add(render(camera, kAhead, kWalls, ++now), 1, kAhead, 0);
  take();
  for (const auto& [index, count] : vertices) {
    if (index.x * 0.8 < 2.5) CHECK(count == 0);
  }
}

TEST_CASE("A new segment has a volume of its own and the last one is said to its end") {
  const DepthCamera camera = make_depth_camera();
  Mapper mapper({}, camera);
  for (int i = 1; i <= 3; ++i) mapper.add(render(camera, kAhead, kWalls, i), 1, kAhead, 0);
  CHECK(mapper.take_due().empty());
  mapper.add(render(camera, kBack, kWalls, 4), 2, kBack, 0);
  const std::vector<mesh_block_t> of_first = mapper.take_due();
  REQUIRE(of_first.size() > 20);
  for (const mesh_block_t& block : of_first) CHECK((block.segment == 1 && block.x >= 0));
  const std::vector<mesh_block_t> of_second = mapper.take_all();
  REQUIRE(of_second.size() > 20);
  for (const mesh_block_t& block : of_second) CHECK((block.segment == 2 && block.x < 0));
}

TEST_CASE("The newest keyframe at a stamp") {
  KeyframeStamps stamps;
  stamps.add(5, 0, 100);
  stamps.add(5, 1, 200);
  stamps.add(5, 1, 250);  // said twice
  stamps.add(5, 3, 300);  // one was lost
  stamps.add(6, 0, 1000);
  CHECK(stamps.newest_at(5, 99) == -1);
  CHECK(stamps.newest_at(5, 100) == 0);
  CHECK(stamps.newest_at(5, 299) == 1);
  CHECK(stamps.newest_at(5, 5000) == 3);
  CHECK(stamps.newest_at(6, 999) == -1);
  CHECK(stamps.newest_at(7, 999) == -1);
}
