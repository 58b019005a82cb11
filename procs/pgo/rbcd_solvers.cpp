// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>

#include "core/pgo/cost.h"
#include "core/pgo/start.h"
#include "procs/pgo/solvers.h"
#include "procs/pgo/team_solution.h"

namespace covey {
namespace {

Solution solve_rbcd(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed;
  distributed.dgnc.robust = false;
  distributed.dgnc.tolerance = 1e-9;
  distributed.start = pgo::chordal_start(graph);
  std::clock_t watching = 0;
  if (options.gap) {
    distributed.stop = [&](const pgo::DistributedProgress& progress) {
      const std::clock_t begin = std::clock();
      const bool reached = pgo::cost(graph, progress.poses()) <= *options.optimum * (1.0 + *options.gap);
      watching += std::clock() - begin;
      return reached;
    };
  }
  Solution solution = solve_as_team(graph, distributed);
  solution.team->watch_seconds = static_cast<double>(watching) / CLOCKS_PER_SEC;
  return solution;
}

}  // namespace

std::vector<Solver> rbcd_solvers() {
  return {{"rbcd", "a team's least squares by block-coordinate descent, from a chordal start", false,
           solve_rbcd}};
}

}  // namespace covey
