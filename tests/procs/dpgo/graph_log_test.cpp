// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/graph_log.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/core/pgo/scratch.h"

namespace covey {
namespace {

struct Folder : ScratchFile {
  Folder() { std::filesystem::create_directories(path); }
};

keyframe_t keyframe(int id) {
  keyframe_t message{};
  message.segment = 5;
  message.id = id;
  return message;
}

std::vector<std::string> read_back(const Folder& folder, std::optional<GraphLog>& log) {
  std::vector<std::string> channels;
  log.emplace(folder.path, [&](const std::string& channel, const Bytes&) { channels.push_back(channel); });
  return channels;
}

void write_some(const Folder& folder) {
  std::optional<GraphLog> log;
  REQUIRE(read_back(folder, log).empty());
  for (int id = 0; id < 3; ++id) log->append(keyframe(id), 100 + id);
  loop_t loop{};
  loop.stream = 9;
  loop.number = 6;
  log->append(loop, 200);
}

TEST_CASE("what was taken is read back in order, with the positions of its streams") {
  const Folder folder;
  write_some(folder);
  std::optional<GraphLog> log;
  for (int run = 0; run < 2; ++run) {
    REQUIRE(read_back(folder, log) == std::vector<std::string>{"KEYFRAME", "KEYFRAME", "KEYFRAME", "LOOP"});
    REQUIRE(log->keyframes() == StreamPositions{{5, 3}});
    REQUIRE(log->loops() == StreamPositions{{9, 7}});
    log.reset();
  }
}

TEST_CASE("a log that was cut off is good up to there, and goes on from there") {
  const Folder folder;
  write_some(folder);
  const auto file = folder.path / "dpgo_graph.lcm";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 37);
  std::optional<GraphLog> log;
  REQUIRE(read_back(folder, log).size() == 3);
  log->append(keyframe(3), 300);
  log.reset();
  REQUIRE(read_back(folder, log).size() == 4);
  REQUIRE(log->keyframes() == StreamPositions{{5, 4}});
}

TEST_CASE("a file that is no log is left behind") {
  const Folder folder;
  std::ofstream(folder.path / "dpgo_graph.lcm") << "something else altogether";
  std::optional<GraphLog> log;
  REQUIRE(read_back(folder, log).empty());
  log->append(keyframe(0), 1);
  log.reset();
  REQUIRE(read_back(folder, log).size() == 1);
}

TEST_CASE("a round is read back whole or not at all") {
  const Folder folder;
  std::optional<GraphLog> log;
  read_back(folder, log);
  REQUIRE_FALSE(log->load_round());
  SavedRound round;
  round.solution.round = {4, 1};
  round.solution.graph = 99;
  round.solution.robots = {1, 2};
  round.solution.frame = pgo::frame_name({4, 1}, 1, 5);
  round.solution.segments[5] = {SE3{SO3{}, {1.0, 2.0, 3.0}}, SE3{SO3{}, {4.0, 5.0, 6.0}}};
  trajectory_t part{};
  part.anchor = 1;
  part.n = 2;
  part.segments = {5, 5};
  part.ids = {0, 1};
  part.utimes = {0, 0};
  part.T_W_K = {1, 0, 0, 0, 1, 2, 3, 1, 0, 0, 0, 4, 5, 6};
  part.n_values = 14;
  part.total_poses = 2;
  round.trajectory = {part};
  round.gauges = {{"cost", 2.5}};
  log->save(round, 1);
  const auto loaded = log->load_round();
  REQUIRE(loaded);
  REQUIRE(loaded->solution.round == pgo::RoundName{4, 1});
  REQUIRE(loaded->solution.frame == round.solution.frame);
  REQUIRE(loaded->solution.graph == 99);
  REQUIRE(loaded->solution.robots == std::vector<int>{1, 2});
  REQUIRE(loaded->solution.segments.at(5)[1].translation.y() == 5.0);
  REQUIRE(loaded->gauges == round.gauges);
  SavedRound damaged = round;
  damaged.trajectory[0].T_W_K[12] = std::numeric_limits<double>::quiet_NaN();
  log->save(damaged, 1);
  REQUIRE_FALSE(log->load_round());
  log->save(round, 1);
  const auto file = folder.path / "dpgo_solution.lcm";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 5);
  REQUIRE_FALSE(log->load_round());
}

}  // namespace
}  // namespace covey
