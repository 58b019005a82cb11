// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/elected.h"
#include "procs/pgo/solvers.h"

namespace covey {
namespace {

Solution solve_elected(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::ElectedOptions elected;
  elected.dimension = graph.dimension;
  elected.barc2 = options.barc2;
  pgo::ElectedResult result = pgo::solve_elected(pgo::robust_form(graph), elected);
  Solution solution;
  solution.poses = std::move(result.team.poses);
  solution.iterations = result.iterations;
  solution.weights = std::move(result.team.weights);
  solution.team = Solution::Team{0, 1, 0, 0.0};
  for (const auto& [type, bytes] : result.team.bytes) solution.team->bytes_sent += bytes;
  return solution;
}

}  // namespace

std::vector<Solver> elected_solvers() {
  return {
      {"elected", "one robot of the team gathers the graph, solves it as gnc does and returns the poses",
       true, solve_elected},
  };
}

}  // namespace covey
