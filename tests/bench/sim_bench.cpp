// SPDX-License-Identifier: BSD-3-Clause
// Time of simulated frames: a stereo set and a depth frame in the town and in the room, drawn in one thread, and of making the worlds.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>

#include "core/sim/cameras.h"

using namespace covey;
using namespace covey::sim;

namespace {

Rig rig_of(const char* name) {
  return read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/sensors" / name);
}

// Along the first street and around the corner; in the room, around.
SE3 town_pose(int frame) {
  const double s = 0.25 * (frame % 256);
  const bool turned = s >= 32.0;
  return {SO3::exp(Eigen::Vector3d(0, 0, turned ? 1.5707963 : 0.0)),
          {turned ? 32.0 : s, turned ? s - 32.0 : 0.0, 0.5}};
}

// The body's x is up on EuRoC's vehicle.
SE3 room_pose(int frame) {
  const SO3 upright = SO3::exp(Eigen::Vector3d(0, -1.5707963, 0));
  return {SO3::exp(Eigen::Vector3d(0, 0, 0.05 * frame)) * upright, {0.0, 0.5, 1.5}};
}

void town_stereo(benchmark::State& state) {
  SensorCameras cameras(make_town(), rig_of("rover.yaml"), {.samples = static_cast<int>(state.range(0))});
  int frame = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(cameras.stereo(town_pose(frame), frame));
    ++frame;
  }
}

void room_stereo(benchmark::State& state) {
  SensorCameras cameras(make_room(), rig_of("euroc.yaml"), {.samples = static_cast<int>(state.range(0))});
  int frame = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(cameras.stereo(room_pose(frame), frame));
    ++frame;
  }
}

void town_depth(benchmark::State& state) {
  SensorCameras cameras(make_town(), rig_of("rover.yaml"));
  int frame = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(cameras.depth(town_pose(frame), frame));
    ++frame;
  }
}

void town_itself(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(make_town());
}

BENCHMARK(town_stereo)->Arg(1)->Arg(4)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(room_stereo)->Arg(1)->Arg(4)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(town_depth)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();
BENCHMARK(town_itself)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
