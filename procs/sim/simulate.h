// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The process `sim`, from its options to its exit: which world, which robots, and where their data go.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace covey {

struct SimOptions {
  std::string world;  // empty: grid with --graph, with --motion the one that it fits in, else town
  int robots = 3;
  int robot = -1;        // whose sensors; of `grid`, only this one's files; -1: every robot's
  double seconds = 0.0;  // 0: 45, grid 120, with --motion all of it; with --motion at most
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> imu_seed;  // of the simulated IMU's errors; none: they follow `seed`, too
  std::filesystem::path data;             // of recorded motion
  std::filesystem::path motion;           // of one recorded flight, which one robot flies
  std::filesystem::path config;           // a robot's configuration; empty: the one that suits the world

  // Where to. Of sensors at most one.
  std::filesystem::path log;
  std::filesystem::path asl;
  std::string url;
  std::string depth_url;  // empty: url
  double speed = 1.0;
  bool no_depth = false;
  bool imu_only = false;  // no pictures of any kind
  std::filesystem::path truth;
  std::filesystem::path graph;      // of the world `grid`
  std::filesystem::path smoothing;  // figures of every recorded sequence
};

void add_sim_options(CLI::App& app, SimOptions& options);

// Throws InputError, and Interrupted after SIGINT or SIGTERM.
void simulate(const SimOptions& options);

}  // namespace covey
