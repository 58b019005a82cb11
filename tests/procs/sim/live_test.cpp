// SPDX-License-Identifier: BSD-3-Clause
// sim onto buses, in a network of the test's own.
#include <catch2/catch.hpp>

#include "procs/common/bus.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"

using namespace covey;

TEST_CASE("sim --url publishes the sensors as they come, DEPTH on a bus of its own, and ends") {
  constexpr Utime kBegin = 1'600'000'000'000'000;
  const ScratchFile said;
  EventLoop loop;
  Status counts;
  Bus sensors({sensor_bus_url(7), {}, nullptr}, loop, counts);
  Bus depths({depth_bus_url(7), {}, nullptr}, loop, counts);
  std::vector<Utime> imu;
  std::vector<Utime> stereo;
  std::vector<Utime> depth;
  sensors.subscribe(kImu, [&](const imu_t& message) { imu.push_back(message.utime); });
  sensors.subscribe(kStereo, [&](const stereo_t& message) { stereo.push_back(message.utime); }, {});
  depths.subscribe(kDepth, [&](const depth_t& message) { depth.push_back(message.utime); }, {});
  ChildProcess sim("sim",
                   {"--world", "town", "--robot", "0", "--seconds", "2", "--speed", "0.5", "--url",
                    sensor_bus_url(7), "--depth-url", depth_bus_url(7)},
                   said.path);
  std::optional<int> exit_code;
  loop.call_every(20'000, [&] {
    if (exit_code) return;
    exit_code = sim.wait(0.001);
    if (exit_code) loop.call_at(loop.now() + 100'000, [&] { loop.stop(); });
  });
  loop.call_at(loop.now() + 100 * kUsPerSecond, [&] { loop.stop(); });
  loop.run();
  INFO(sim.output());
  CHECK(exit_code == 0);
  REQUIRE(imu.size() == 401);
  REQUIRE(stereo.size() == 41);
  REQUIRE(depth.size() == 11);
  CHECK(imu.front() == kBegin);
  CHECK(stereo.back() == kBegin + 2 * kUsPerSecond);
  CHECK(depth.back() == kBegin + 2 * kUsPerSecond);
}
