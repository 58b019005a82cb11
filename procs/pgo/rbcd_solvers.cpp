// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>
#include <utility>

#include "core/pgo/cost.h"
#include "core/pgo/rbcd.h"
#include "core/pgo/start.h"
#include "procs/pgo/solvers.h"

namespace covey {
namespace {

Solution solve_rbcd(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::RbcdOptions rbcd;
  rbcd.schedule = options.schedule;
  rbcd.seed = options.seed;
  std::clock_t watching = 0;
  if (options.gap) {
    const double enough = *options.optimum * (1.0 + *options.gap);
    rbcd.stop = [&watching, &graph, enough](const pgo::RbcdProgress& progress) {
      const std::clock_t begin = std::clock();
      const bool reached = progress.cost <= enough && pgo::cost(graph, progress.poses()) <= enough;
      watching += std::clock() - begin;
      return reached;
    };
  }
  pgo::RbcdResult result = pgo::solve_rbcd(graph, pgo::chordal_start(graph), rbcd);
  Solution solution;
  solution.poses = std::move(result.poses);
  solution.iterations = result.block_updates;
  if (!options.gap) solution.converged = result.converged;
  solution.team =
      Solution::Team{result.block_updates, result.rounds, 0, static_cast<double>(watching) / CLOCKS_PER_SEC};
  for (const auto& [kind, bytes] : result.bytes) solution.team->bytes_sent += bytes;
  return solution;
}

}  // namespace

std::vector<Solver> rbcd_solvers() {
  return {{"rbcd", "a team's least squares by block-coordinate descent, from a chordal start; see --schedule",
           false, solve_rbcd}};
}

}  // namespace covey
