// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A team in a world: what there is to see, how each robot moves through it, and what its IMU measures. All robots begin at one utime.
//
// town, rooms: drives through the streets, or along a corridor and around in rooms (core/sim/routes.h), with a simulated IMU. euroc-v1: robot i flies as the vehicle of EuRoC's sequence
// V1_0<i+1> did, with its real IMU samples, from two seconds before it took off; the stamps are moved to a common begin. euroc-mh: the same with
// the four sequences MH_01, MH_03, MH_04 and MH_05, in a machine hall. Any other recorded flight can be flown in their place.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/rig.h"
#include "core/sim/drive.h"
#include "core/sim/euroc_motion.h"
#include "core/sim/imu.h"
#include "core/sim/mesh_world.h"

namespace covey::sim {

constexpr int kStereoHz = 20;
constexpr int kDepthHz = 5;

struct ScenarioOptions {
  std::string world = "town";
  int robots = 3;
  double seconds = 45.0;  // with `motion`: at most
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> imu_seed;  // of the errors of a simulated IMU alone; none: they follow `seed`
  std::filesystem::path data;             // the folder that has euroc/motion/SEQUENCE
  std::filesystem::path motion;           // or a folder like SEQUENCE, which the only robot flies
  ImuNoise imu;
};

struct Ride {
  std::string name;  // of the sequence; empty where one drives
  Motion motion;
  ImuRecord imu;
  std::optional<EurocEvidence> evidence;  // of a smoothed motion
};

struct Scenario {
  MeshWorld world;
  int robots = 0;
  std::function<Ride(int robot)> ride;  // made when asked for: the motion of a real sequence takes a second
};

// Of euroc-v1 and euroc-mh, the one that a recorded flight fits in: the hall is built around any. InputError where it cannot be read.
std::string world_for(const std::filesystem::path& motion);

// InputError where the world has no such many robots, or no such much time, or its data are not there.
Scenario make_scenario(const ScenarioOptions& options);

}  // namespace covey::sim
