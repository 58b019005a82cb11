// SPDX-License-Identifier: BSD-3-Clause
// The mesher as a process: from a log, and beside a player on buses in a network of the test's own.
#include <catch2/catch.hpp>
#include <map>

#include "core/mesh/block.h"
#include "procs/common/bus.h"
#include "procs/common/sensor_log.h"
#include "procs/player/given_odometry.h"
#include "procs/player/rgbd_folder.h"
#include "tests/child_process.h"
#include "tests/procs/player/rgbd_stage.h"
#include "tests/wait_until.h"
#include "viewer_offscreen/ply.h"

using namespace covey;

namespace {

constexpr double kPatienceS = 60.0;

struct Said {
  std::vector<mesh_block_t> blocks;
  std::map<std::string, std::int64_t> counters;  // of the newest STATUS
};

// What a process recorded.
Said read_said(const ScratchFile& log) {
  Said said;
  EventLoop loop;
  Status status;
  Bus bus({"file://" + log.path.string(), {}, nullptr}, loop, status);
  bus.subscribe(kMesh, [&](const mesh_block_t& block) { said.blocks.push_back(block); });
  bus.subscribe(kStatus, [&](const status_t& message) {
    for (std::size_t i = 0; i < message.counter_names.size(); ++i)
      said.counters[message.counter_names[i]] = message.counter_values[i];
  });
  loop.run();
  return said;
}

// Fifteen images of the stage's wall, 0.2 s apart, with STATEs at 100 Hz that begin 0.3 s after the first image.
void write_log(const RgbdStage& stage, const std::filesystem::path& file) {
  RgbdFrame frame;
  frame.depth = stage.path / "frame-000000.depth.png";
  frame.colour = stage.path / "frame-000000.color.png";
  frame.labels = stage.path / "frame-000000.segm.png";
  const depth_t wall = load_depth(frame, 1000.0);
  SensorLogWriter writer(file.string());
  GivenOdometry odometry(3);
  for (Utime utime = 0; utime <= 3'000'000; utime += 10'000) {
    const SE3 T_O_B{{}, {0.0, 1e-7 * static_cast<double>(utime), 0.0}};
    const bool has_image = utime % 200'000 == 0;
    depth_t image = wall;
    image.utime = 1'000'000 + utime + (has_image ? 5'000 : 0);
    if (utime >= 300'000) {
      const GivenOdometry::Said said = odometry.add(1'000'000 + utime, T_O_B);
      if (utime == 2'050'000) {
        state_t astray = said.state;
        astray.utime -= 2'000;
        astray.t_O_B[0] = 1e300;
        writer.write(kState, astray);
      }
      writer.write(kState, said.state);
      if (said.keyframe) writer.write(kKeyframe, *said.keyframe);
    }
    if (utime == 2'000'000) {
      image.depth_mm.pop_back();
      image.n_depth = static_cast<std::int32_t>(image.depth_mm.size());
    }
    if (has_image) writer.write(kDepth, image);
  }
  REQUIRE(writer.finish());
}

}  // namespace

TEST_CASE("mesher makes the mesh of a log, the same each time") {
  RgbdStage stage;
  stage.write_frames(1);
  const ScratchFile log;
  write_log(stage, log.path);
  const ScratchFile said_on_screen;
  std::array<ScratchFile, 2> outs;
  const ScratchFile ply;
  for (const ScratchFile& out : outs) {
    ChildProcess mesher("mesher",
                        {"--robot", "3", "--config", stage.write_config(), "--url",
                         "file://" + log.path.string(), "--out", out.path, "--ply", ply.path},
                        said_on_screen.path);
    const std::optional<int> code = mesher.wait(kPatienceS);
    INFO(mesher.output());
    REQUIRE(code == 0);
  }
  const Said said = read_said(outs[0]);
  const Said again = read_said(outs[1]);
  REQUIRE(said.blocks.size() > 20);
  REQUIRE(said.blocks.size() == again.blocks.size());
  std::map<mesh::BlockIndex, const mesh_block_t*> newest;
  for (std::size_t i = 0; i < said.blocks.size(); ++i) {
    const mesh_block_t& block = said.blocks[i];
    CHECK(encode(block) == encode(again.blocks[i]));
    CHECK(block.number == static_cast<int>(i));
    CHECK(block.stream == said.blocks.front().stream);
    CHECK(block.robot == 3);
    CHECK(block.segment == 1'300'000);
    newest[{block.x, block.y, block.z}] = &block;
  }
  // Fifteen images and one of them damaged; the first two came before any STATE.
  CHECK(said.counters.at("dropped/DEPTH/size") == 1);
  CHECK(said.counters.at("dropped/STATE/values") == 1);
  CHECK(said.counters.at("dropped/DEPTH/no_pose") == 2);
  CHECK(said.counters.at("integrated") == 12);

  // The wall is 2 m ahead of the body, which looks along x.
  const viewer::Mesh mesh = viewer::read_ply(ply.path);
  std::size_t vertices = 0;
  int newest_keyframe = -1;
  for (const auto& [index, block] : newest) {
    vertices += block->labels.size();
    for (const int keyframe : block->keyframes) newest_keyframe = std::max(newest_keyframe, keyframe);
  }
  CHECK(newest_keyframe == 2);
  REQUIRE(mesh.vertices.size() == vertices);
  REQUIRE(mesh.vertices.size() > 500);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    CHECK(mesh.vertices[i].x() == Approx(2.0).margin(1e-3));
    CHECK(mesh.labels[i] == 3);
    CHECK(mesh.colours[i].r == 10);
  }
  for (const auto& face : mesh.faces) {
    const Eigen::Vector3f a = mesh.vertices[face[0]];
    CHECK((mesh.vertices[face[1]] - a).cross(mesh.vertices[face[2]] - a).x() < 0.0F);  // towards the camera
  }
}

TEST_CASE("mesher says in one sentence what it cannot start with") {
  const ScratchFile said;
  const ScratchFile config("mesher: {voxel_m: 0.05}\n");
  ChildProcess no_rig("mesher", {"--robot", "3", "--config", config.path}, said.path);
  CHECK(no_rig.wait(kPatienceS) == 2);
  CHECK_THAT(no_rig.output(), Catch::Contains("'sensors' is missing"));
  RgbdStage stage;
  stage.write_config();
  std::ofstream(stage.path / "robot.yaml") << "sensors: rig.yaml\nmesher: {voxel_m: 5.0}\n";
  ChildProcess large("mesher", {"--robot", "3", "--config", stage.path / "robot.yaml"}, said.path);
  CHECK(large.wait(kPatienceS) == 2);
  CHECK_THAT(large.output(), Catch::Contains("mesher.voxel_m"));
}

TEST_CASE("player and mesher make a mesh over multicast") {
  constexpr int kImages = 12;
  RgbdStage stage;
  stage.write_frames(kImages);
  const std::filesystem::path config = stage.write_config();
  const ScratchFile ply;
  const ScratchFile mesher_said;
  const ScratchFile player_said;
  EventLoop loop;
  Status counts;
  Bus bus({robot_bus_url(3), {}, nullptr}, loop, counts);
  std::map<std::string, std::int64_t> counters;
  bool mesher_is_there = false;
  bus.subscribe(kStatus, [&](const status_t& status) {
    if (status.process != "mesher") return;
    mesher_is_there = true;
    for (std::size_t i = 0; i < status.counter_names.size(); ++i)
      counters[status.counter_names[i]] = status.counter_values[i];
  });
  std::vector<mesh_block_t> blocks;
  bus.subscribe(kMesh, [&](const mesh_block_t& block) { blocks.push_back(block); });

  ChildProcess mesher("mesher", {"--robot", "3", "--config", config, "--ply", ply.path}, mesher_said.path);
  REQUIRE(wait_until(loop, kPatienceS, [&] { return mesher_is_there; }));
  ChildProcess player("player",
                      {"--robot", "3", "--config", config, "--tum-rgbd", stage.path, "--speed", "1"},
                      player_said.path);
  // All are mapped, and then said without anything more coming in.
  INFO(mesher.output() + player.output());
  REQUIRE(
      wait_until(loop, kPatienceS, [&] { return counters["integrated"] == kImages && blocks.size() > 20; }));
  CHECK(player.wait(kPatienceS) == 0);
  mesher.kill(SIGTERM);
  REQUIRE(mesher.wait(kPatienceS) == 0);
  CHECK(viewer::read_ply(ply.path).vertices.size() > 500);
  for (std::size_t i = 0; i < blocks.size(); ++i) CHECK(blocks[i].number == static_cast<int>(i));
}
