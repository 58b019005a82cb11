// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/robot_mesh.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/mesh/mesh_job.h"
#include "core/mesh/optimized_parts.h"
#include "tests/core/mesh/corridor_messages.h"

using namespace covey;
using namespace covey::mesh;

namespace {

struct Fixture {
  testing::Corridor corridor = testing::make_corridor(testing::bend, {.length_m = 20.0});
  testing::CorridorBlocks blocks = testing::block_messages(corridor);
  RobotMesh mesh{0};

  void take_keyframes() {
    for (const keyframe_t& message : testing::keyframe_messages(corridor))
      REQUIRE(mesh.take(message) == nullptr);
  }
  void take_blocks() {
    for (const mesh_block_t& message : blocks.messages) REQUIRE(mesh.take(message) == nullptr);
  }
  void take_round(std::int64_t round, Utime utime, std::size_t keyframes = 1000) {
    for (const trajectory_t& part : testing::trajectory_messages(corridor, round, utime, keyframes)) {
      REQUIRE(mesh.take(part) == nullptr);
    }
  }
  std::vector<Eigen::Vector3f> truth() const {
    std::vector<Eigen::Vector3f> p_W;
    for (const auto& of_block : blocks.p_W) p_W.insert(p_W.end(), of_block.begin(), of_block.end());
    return p_W;
  }
};

MeshJob done(const MeshSnapshot& snapshot) {
  MeshJob job(snapshot, {});
  while (job.advance()) continue;
  return job;
}

}  // namespace

TEST_CASE("RobotMesh: blocks, keyframes and a round become a mesh that can be deformed") {
  Fixture fixture;
  fixture.take_blocks();
  REQUIRE(fixture.mesh.team().mesh.p_O.empty());
  fixture.take_keyframes();
  fixture.take_round(3, 100);
  const MeshSnapshot snapshot = fixture.mesh.team();
  REQUIRE(snapshot.left_out == 0);
  REQUIRE(snapshot.keyframes.size() == fixture.corridor.keyframes.size());
  REQUIRE(snapshot.mesh.faces.size() == fixture.corridor.mesh.faces.size());
  REQUIRE(snapshot.labels.size() == snapshot.mesh.p_O.size());
  REQUIRE(static_cast<std::int64_t>(snapshot.labels.size()) == fixture.mesh.vertices());
  const testing::Distances after = testing::distances(done(snapshot).moved(), fixture.truth());
  REQUIRE(after.mean_m < 0.002);
  REQUIRE(after.max_m < 0.01);
}

TEST_CASE("RobotMesh: the mesh as measured is that of the first segment, untouched") {
  Fixture fixture;
  fixture.take_keyframes();
  fixture.take_blocks();
  mesh_block_t later = fixture.blocks.messages[2];
  later.segment += 1000;
  keyframe_t keyframe = testing::keyframe_messages(fixture.corridor)[0];
  keyframe.segment = later.segment;
  REQUIRE(fixture.mesh.take(later) == nullptr);
  REQUIRE(fixture.mesh.take(keyframe) == nullptr);
  const MeshSnapshot snapshot = fixture.mesh.odometry();
  REQUIRE(snapshot.left_out == later.n_vertices);
  std::size_t at = 0;
  for (const mesh_block_t& block : fixture.blocks.messages) {
    for (int v = 0; v < block.n_vertices; ++v, ++at) REQUIRE(snapshot.mesh.p_O[at].x() == block.p_O[3 * v]);
  }
  REQUIRE(at == snapshot.mesh.p_O.size());
}

TEST_CASE("RobotMesh: keyframes beyond the round go on by odometry, segments that it lacks are left out") {
  Fixture fixture;
  fixture.take_keyframes();
  fixture.take_blocks();
  fixture.take_round(1, 100, 30);
  mesh_block_t later = fixture.blocks.messages[2];
  later.segment += 1000;
  REQUIRE(fixture.mesh.take(later) == nullptr);
  const MeshSnapshot snapshot = fixture.mesh.team();
  REQUIRE(snapshot.left_out == later.n_vertices);
  const PlacedKeyframe& last = snapshot.keyframes[29];
  const PlacedKeyframe& beyond = snapshot.keyframes.back();
  const SE3 by_odometry = last.T_W_K * last.T_O_K.inverse() * beyond.T_O_K;
  REQUIRE((by_odometry.matrix() - beyond.T_W_K.matrix()).norm() < 1e-9);
}

TEST_CASE(
    "RobotMesh: a block that is said again replaces the old one, and vertices without a keyframe find one") {
  Fixture fixture;
  fixture.take_keyframes();
  fixture.take_blocks();
  const std::int64_t vertices = fixture.mesh.vertices();
  mesh_block_t& block = fixture.blocks.messages[4];
  block.number = 1000;
  for (std::int32_t& keyframe : block.keyframes) keyframe = -1;
  block.utime = from_seconds(3.7);
  REQUIRE(fixture.mesh.take(block) == nullptr);
  REQUIRE(fixture.mesh.vertices() == vertices);
  REQUIRE(fixture.mesh.blocks().size() == fixture.blocks.messages.size());
  fixture.take_round(1, 100);
  const MeshSnapshot snapshot = fixture.mesh.team();
  std::size_t at = 0;
  for (int b = 0; b < 4; ++b) at += fixture.blocks.messages[b].labels.size();
  REQUIRE(snapshot.keyframes[snapshot.mesh.seen_by[at]].utime == from_seconds(3.5));
  mesh_block_t empty{};
  empty.stream = testing::kMeshStream;
  empty.segment = block.segment;
  empty.x = 4;
  empty.number = 1001;
  REQUIRE(fixture.mesh.take(empty) == nullptr);
  REQUIRE(fixture.mesh.vertices() == vertices - block.n_vertices);
}

TEST_CASE("RobotMesh: rounds count when they are whole, and the newest wins") {
  Fixture fixture;
  const auto first = testing::trajectory_messages(fixture.corridor, 1, 100);
  const auto second = testing::trajectory_messages(fixture.corridor, 2, 200);
  REQUIRE(first.size() == 3);
  REQUIRE(fixture.mesh.take(first[0]) == nullptr);
  REQUIRE(fixture.mesh.take(first[0]) == std::string("duplicate"));
  REQUIRE(fixture.mesh.take(second[2]) == nullptr);
  REQUIRE(fixture.mesh.take(first[1]) == std::string("old"));
  REQUIRE(fixture.mesh.round().empty());
  REQUIRE(fixture.mesh.take(second[0]) == nullptr);
  REQUIRE(fixture.mesh.take(second[1]) == nullptr);
  REQUIRE(fixture.mesh.round().size() == 3);
  REQUIRE(fixture.mesh.round().front().round == 2);
  REQUIRE(fixture.mesh.take(second[1]) == std::string("duplicate"));
  REQUIRE(fixture.mesh.take(first[2]) == std::string("old"));
}

TEST_CASE("RobotMesh: what makes no sense is refused") {
  Fixture fixture;
  const auto refuses = [&](auto change) {
    mesh_block_t block = fixture.blocks.messages[0];
    change(block);
    return fixture.mesh.take(block) != nullptr;
  };
  REQUIRE(refuses([](mesh_block_t& b) { b.robot = 3; }));
  REQUIRE(refuses([](mesh_block_t& b) { b.corners[5] = b.n_vertices; }));
  REQUIRE(refuses([](mesh_block_t& b) { b.corners[5] = -1; }));
  REQUIRE(refuses([](mesh_block_t& b) { b.p_O[7] = std::numeric_limits<float>::quiet_NaN(); }));
  REQUIRE(refuses([](mesh_block_t& b) { b.p_O[7] = 1e20F; }));
  REQUIRE(refuses([](mesh_block_t& b) { b.n_values -= 3; }));
  REQUIRE(refuses([](mesh_block_t& b) { b.n_corners -= 1; }));
  REQUIRE_FALSE(refuses([](mesh_block_t&) {}));
  keyframe_t keyframe = testing::keyframe_messages(fixture.corridor)[0];
  keyframe.q_O_K[0] = 3.0;
  REQUIRE(fixture.mesh.take(keyframe) == std::string("values"));
  trajectory_t part = testing::trajectory_messages(fixture.corridor, 1, 1)[0];
  part.T_W_K[9] = std::numeric_limits<double>::infinity();
  part.T_W_K[4] = std::numeric_limits<double>::infinity();
  REQUIRE(fixture.mesh.take(part) == std::string("values"));
}

TEST_CASE("whole_faces: what lies between two passes is torn, what bends is not") {
  Fixture fixture;
  fixture.take_keyframes();
  fixture.take_blocks();
  fixture.take_round(1, 100);
  REQUIRE(done(fixture.mesh.team()).torn() == 0);
  MeasuredMesh mesh;
  mesh.p_O = {{0.0F, 0.0F, 0.0F}, {0.1F, 0.0F, 0.0F}, {0.0F, 0.1F, 0.0F}, {0.1F, 0.1F, 0.0F}};
  mesh.faces = {{0, 1, 2}, {1, 3, 2}};
  std::vector<Eigen::Vector3f> p_W = mesh.p_O;
  p_W[3].z() += 0.2F;
  REQUIRE(whole_faces(mesh, p_W).size() == 2);
  p_W[3].z() += 0.3F;
  REQUIRE(whole_faces(mesh, p_W) == std::vector<Face>{{0, 1, 2}});
}

TEST_CASE("optimized_parts: every face once, in parts of at most 1500 vertices") {
  Fixture fixture;
  fixture.take_keyframes();
  fixture.take_blocks();
  fixture.take_round(1, 100);
  const MeshSnapshot snapshot = fixture.mesh.team();
  const MeshJob job = done(snapshot);
  mesh_optimized_t name{};
  name.round = 9;
  const auto parts = optimized_parts(name, snapshot, job.moved());
  REQUIRE(parts.size() > 5);
  std::size_t faces = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const mesh_optimized_t& part = parts[k];
    REQUIRE(part.round == 9);
    REQUIRE(part.part == static_cast<int>(k));
    REQUIRE(part.parts == static_cast<int>(parts.size()));
    REQUIRE(part.n_vertices <= kVerticesPerPart);
    REQUIRE(part.p_W.size() == 3 * part.labels.size());
    REQUIRE(part.n_values == static_cast<int>(part.p_W.size()));
    REQUIRE(part.n_corners == static_cast<int>(part.corners.size()));
    for (int c = 0; c < part.n_corners; c += 3, ++faces) {
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t v = snapshot.mesh.faces[faces][i];
        const int at = part.corners[c + i];
        REQUIRE(part.p_W[3 * at + 1] == job.moved()[v].y());
        REQUIRE(part.labels[at] == snapshot.labels[v]);
        REQUIRE(part.colours[3 * at + 2] == snapshot.colours[3 * v + 2]);
      }
    }
  }
  REQUIRE(faces == snapshot.mesh.faces.size());
}
