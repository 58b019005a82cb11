// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>

#include "core/pgo/cost.h"
#include "core/pgo/solve_schur.h"
#include "core/pgo/start.h"
#include "procs/pgo/solvers.h"

namespace covey {
namespace {

Solution solve_schur(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::SolveSchurOptions schur;
  std::clock_t watching = 0;
  if (options.gap) {
    schur.stop = [&](const std::function<pgo::Poses()>& poses) {
      const std::clock_t begin = std::clock();
      const bool reached = pgo::cost(graph, poses()) <= *options.optimum * (1.0 + *options.gap);
      watching += std::clock() - begin;
      return reached;
    };
  }
  const pgo::SolveSchurResult result = pgo::solve_schur(graph, pgo::chordal_start(graph), schur);
  Solution solution;
  solution.poses = result.poses;
  solution.iterations = result.rounds;
  solution.converged = result.converged;
  solution.team = Solution::Team{};
  solution.team->block_updates = result.block_updates;
  solution.team->rounds = result.rounds;
  for (const auto& [type, bytes] : result.bytes) solution.team->bytes_sent += bytes;
  solution.team->watch_seconds = static_cast<double>(watching) / CLOCKS_PER_SEC;
  return solution;
}

}  // namespace

std::vector<Solver> schur_solvers() {
  return {
      {"schur", "a team's least squares by second-order steps, from a chordal start", false, solve_schur}};
}

}  // namespace covey
