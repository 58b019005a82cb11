// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lmo/mesh_log.h"

#include <catch2/catch.hpp>
#include <optional>

#include "tests/core/mesh/corridor_messages.h"
#include "tests/core/pgo/scratch.h"

namespace covey {
namespace {

struct Folder : ScratchFile {
  Folder() { std::filesystem::create_directories(path); }
  std::filesystem::path log() const { return path / "lmo.lcm"; }
};

struct Run {
  explicit Run(const Folder& folder) : log(folder.path, mesh) {}

  template <typename T>
  void take(const T& message) {
    REQUIRE(mesh.take(message) == nullptr);
    log.append(message, 1);
  }

  mesh::RobotMesh mesh{0};
  MeshLog log;
};

testing::Corridor corridor() {
  return testing::make_corridor([](double) { return SE3{}; }, {.length_m = 10.0});
}

void write_some(const Folder& folder) {
  Run run(folder);
  for (const keyframe_t& message : testing::keyframe_messages(corridor())) run.take(message);
  for (const mesh_block_t& message : testing::block_messages(corridor()).messages) run.take(message);
  for (const trajectory_t& message : testing::trajectory_messages(corridor(), 4, 50)) run.take(message);
}

TEST_CASE("what lmo has taken is read back, with the positions of its streams") {
  const Folder folder;
  write_some(folder);
  for (int time = 0; time < 2; ++time) {
    const Run run(folder);
    REQUIRE(run.mesh.blocks().size() == 10);
    REQUIRE(run.mesh.keyframes().size() == 21);
    REQUIRE(run.mesh.round().front().round == 4);
    REQUIRE(run.log.blocks() == StreamPositions{{testing::kMeshStream, 10}});
    REQUIRE(run.log.keyframes() == StreamPositions{{7, 21}});
  }
}

TEST_CASE("blocks that were said again take no room after a restart") {
  const Folder folder;
  write_some(folder);
  const auto bytes = std::filesystem::file_size(folder.log());
  {
    Run run(folder);
    mesh_block_t block = testing::block_messages(corridor()).messages[3];
    for (int number = 10; number < 60; ++number) {
      block.number = number;
      run.take(block);
    }
    REQUIRE(std::filesystem::file_size(folder.log()) > 2 * bytes);
  }
  const Run run(folder);
  REQUIRE(std::filesystem::file_size(folder.log()) == bytes);
  REQUIRE(run.log.blocks() == StreamPositions{{testing::kMeshStream, 60}});
}

TEST_CASE("lmo's log that was cut off is good up to there") {
  const Folder folder;
  write_some(folder);
  std::filesystem::resize_file(folder.log(), std::filesystem::file_size(folder.log()) / 2);
  const Run run(folder);
  REQUIRE(run.mesh.keyframes().size() == 21);
  REQUIRE(run.mesh.blocks().size() > 2);
  REQUIRE(run.mesh.blocks().size() < 10);
  REQUIRE(run.log.blocks().at(testing::kMeshStream) == static_cast<int>(run.mesh.blocks().size()));
  std::ofstream(folder.log()) << "something else altogether";
  REQUIRE(Run(folder).mesh.blocks().empty());
}

}  // namespace
}  // namespace covey
