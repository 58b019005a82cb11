// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The world `grid` as files: DIR/robot<i>.csv, the robot's measurements (core/pgo/robot_csv.h), and
// DIR/robot<i>_truth.tum, where it really was.

#include <cstdint>
#include <filesystem>
#include <string>

namespace CLI {
class App;
}

namespace covey {

struct SimOptions {
  std::string world = "grid";
  int robots = 3;
  int robot = -1;  // only this one's files; -1: every robot's
  double seconds = 120.0;
  std::uint64_t seed = 1;
  std::filesystem::path graph;   // output folder
  std::filesystem::path config;  // YAML with a section `sim`; empty: none
};

void add_sim_options(CLI::App& app, SimOptions& options);
void simulate(const SimOptions& options);

}  // namespace covey
