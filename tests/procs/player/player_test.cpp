// SPDX-License-Identifier: BSD-3-Clause
// The player as a process: a folder in EuRoC's layout into a log, and onto a bus in a network of the test's own.
#include <catch2/catch.hpp>

#include "procs/common/bus.h"
#include "procs/common/log_file.h"
#include "tests/child_process.h"
#include "tests/procs/player/asl_stage.h"

using namespace covey;

namespace {

struct Heard {
  std::vector<Utime> imu;
  std::vector<Utime> stereo;
};

std::vector<Utime> every(Utime step, int count) {
  std::vector<Utime> utimes;
  for (int i = 0; i < count; ++i) utimes.push_back((AslStage::kFirstNs + 500) / 1000 + step * i);
  return utimes;
}

void listen(Bus& bus, Heard& heard) {
  bus.subscribe(kImu, [&heard](const imu_t& message) { heard.imu.push_back(message.utime); });
  bus.subscribe(kStereo, [&heard](const stereo_t& message) { heard.stereo.push_back(message.utime); }, {});
}

}  // namespace

TEST_CASE("player --asl --out makes a log of the sensors, the same each time") {
  const AslStage stage(4, ".png");
  const ScratchFile first;
  const ScratchFile second;
  const ScratchFile said;
  for (const ScratchFile* log : {&first, &second}) {
    ChildProcess player("player", {"--asl", stage.path, "--out", log->path}, said.path);
    REQUIRE(player.wait(30.0) == 0);
  }
  CHECK(read_text(first.path) == read_text(second.path));
  EventLoop loop;
  Status counts;
  Heard heard;
  Bus bus({"file://" + first.path.string(), {}, nullptr}, loop, counts);
  listen(bus, heard);
  loop.run();
  CHECK(heard.imu == every(5'000, 40));
  CHECK(heard.stereo == every(50'000, 4));
}

TEST_CASE("player refuses what it cannot play, with one sentence and exit code 2") {
  const ScratchFile said;
  const ScratchFile log;
  ChildProcess nothing("player", {"--asl", "/nowhere", "--out", log.path}, said.path);
  CHECK(nothing.wait(30.0) == 2);
  CHECK(nothing.output() == "player: --asl /nowhere: has neither mav0/cam0 nor cam0\n");
  ChildProcess two("player", {"--asl", "/nowhere", "--log", "/nowhere", "--out", log.path}, said.path);
  CHECK(two.wait(30.0) == 2);
  ChildProcess no_bus("player", {"--asl", "/nowhere"}, said.path);
  CHECK(no_bus.wait(30.0) == 2);
  CHECK(no_bus.output() == "player: --url is needed where --robot is not given\n");
}

TEST_CASE("player --asl --url plays onto a bus and ends") {
  const AslStage stage(6, ".png");
  const ScratchFile said;
  EventLoop loop;
  Status counts;
  Heard heard;
  Bus bus({sensor_bus_url(7), {}, nullptr}, loop, counts);
  listen(bus, heard);
  ChildProcess player("player", {"--asl", stage.path, "--url", sensor_bus_url(7), "--speed", "2"}, said.path);
  std::optional<int> exit_code;
  loop.call_every(20'000, [&] {
    if (exit_code) return;
    exit_code = player.wait(0.001);
    if (exit_code) loop.call_at(loop.now() + 100'000, [&] { loop.stop(); });
  });
  loop.call_at(loop.now() + 30 * kUsPerSecond, [&] { loop.stop(); });
  loop.run();
  INFO(player.output());
  CHECK(exit_code == 0);
  CHECK(heard.imu == every(5'000, 60));
  CHECK(heard.stereo == every(50'000, 6));
}
