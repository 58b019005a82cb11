// SPDX-License-Identifier: BSD-3-Clause
#include "procs/sim/simulate.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/pgo/robot_csv.h"
#include "core/sim/grid.h"
#include "procs/common/robot_config.h"

namespace covey {
namespace {

sim::GridOptions grid_options(const SimOptions& options) {
  sim::GridOptions grid;
  grid.robots = options.robots;
  grid.keyframes = static_cast<int>(std::floor(options.seconds));
  grid.seed = options.seed;
  Config config = load_robot_config(options.config, "sim");
  sim::read_grid(config.root().section("sim"), grid);
  config.check_all_read();
  return grid;
}

}  // namespace

void add_sim_options(CLI::App& app, SimOptions& options) {
  app.add_option("--world", options.world, "grid: a pose graph of robots that drive through a town")
      ->check(CLI::IsMember({"grid"}))
      ->capture_default_str();
  app.add_option("--robots", options.robots, "how many robots there are")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--robot", options.robot, "write only this robot's files")->check(CLI::Range(0, 63));
  app.add_option("--seconds", options.seconds, "length of the drive; one keyframe a second")
      ->check(CLI::Range(2.0, 100'000.0))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "the same seed gives the same world")->capture_default_str();
  app.add_option("--config", options.config,
                 "YAML with a section 'sim' that overrides the world's parameters");
  app.add_option("--graph", options.graph, "output folder for robot<i>.csv and robot<i>_truth.tum")
      ->required();
}

void simulate(const SimOptions& options) {
  if (options.robot >= options.robots) {
    throw_input_error("--robot {}: there are only robots 0 to {}; raise --robots", options.robot,
                      options.robots - 1);
  }
  const sim::GridWorld world = sim::make_grid(grid_options(options));
  const auto only_robot = options.robot >= 0 ? std::optional<int>(options.robot) : std::nullopt;
  pgo::write_robot_csv(options.graph, world.graph, only_robot);
  for (int r = 0; r < options.robots; ++r) {
    if (only_robot && r != *only_robot) continue;
    write_tum(options.graph / fmt::format("robot{}_truth.tum", r), world.truth[r]);
  }
}

}  // namespace covey
