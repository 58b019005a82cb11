// SPDX-License-Identifier: BSD-3-Clause
#include "procs/sim/grid.h"

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

void write_grid(const SimOptions& options) {
  const sim::GridWorld world = sim::make_grid(grid_options(options));
  const auto only_robot = options.robot >= 0 ? std::optional<int>(options.robot) : std::nullopt;
  pgo::write_robot_csv(options.graph, world.graph, only_robot);
  for (int r = 0; r < options.robots; ++r) {
    if (only_robot && r != *only_robot) continue;
    write_tum(options.graph / fmt::format("robot{}_truth.tum", r), world.truth[r]);
  }
}

}  // namespace covey
