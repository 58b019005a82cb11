// SPDX-License-Identifier: BSD-3-Clause
// vio killed and started again, on buses in a network of the test's own.
#include <signal.h>

#include <catch2/catch.hpp>
#include <map>
#include <memory>

#include "procs/common/bus.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"

using namespace covey;

namespace {

constexpr int kRobot = 6;

std::unique_ptr<ChildProcess> start_vio(const ScratchFile& config, const ScratchFile& state,
                                        const ScratchFile& said) {
  return std::make_unique<ChildProcess>(
      "vio",
      std::vector<std::string>{"--robot", std::to_string(kRobot), "--config", config.path, "--state",
                               state.path},
      said.path);
}

}  // namespace

TEST_CASE(
    "a vio that was killed opens a new segment, and says the keyframes of the old one again to who comes "
    "later") {
  const ScratchFile config(std::string("vio: {source: odometry}\n"));
  const ScratchFile state;
  const ScratchFile said;
  EventLoop loop;
  Status counts;
  Bus sensors({sensor_bus_url(kRobot), {}, nullptr}, loop, counts);
  Bus robot({robot_bus_url(kRobot), {}, nullptr}, loop, counts);
  std::map<std::int64_t, int> before;  // segment -> keyframes
  robot.subscribe(kKeyframe, [&](const keyframe_t& keyframe) { ++before[keyframe.segment]; });

  auto vio = start_vio(config, state, said);
  Utime utime = 1'000'000;
  loop.call_every(20'000, [&] {  // 5 m/s: ten keyframes a second
    odometry_t message{};
    message.utime = utime += 20'000;
    message.q_O_B[0] = 1.0;
    message.t_O_B[0] = 5e-6 * static_cast<double>(utime);
    sensors.publish(kOdometry, message);
  });
  // Each step as soon as the one before is seen.
  std::unique_ptr<Bus> late_bus;
  std::map<std::int64_t, int> late;
  int known = 0;
  loop.call_every(50'000, [&] {
    if (known == 0 && before.size() == 1 && before.begin()->second >= 5) {
      vio->kill(SIGKILL);
      vio->wait(5.0);
      known = before.begin()->second;
      vio = start_vio(config, state, said);
    }
    if (before.size() == 2 && !late_bus) {
      late_bus = std::make_unique<Bus>(BusOptions{robot_bus_url(kRobot), {}, nullptr}, loop, counts);
      late_bus->subscribe(kKeyframe, [&](const keyframe_t& keyframe) { ++late[keyframe.segment]; });
    }
    if (late.size() == 2 && late.begin()->second >= known) loop.stop();
  });
  loop.call_at(loop.now() + 60 * kUsPerSecond, [&] { loop.stop(1); });
  CHECK(loop.run() == 0);
  INFO(vio->output());
  REQUIRE(before.size() == 2);
  CHECK(before.rbegin()->first > before.begin()->first);
  CHECK(late.begin()->first == before.begin()->first);
  CHECK(late.begin()->second >= known);
  vio->kill(SIGTERM);
  CHECK(vio->wait(10.0) == 0);
}
