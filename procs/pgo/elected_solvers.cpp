// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/solvers.h"
#include "procs/pgo/team_solution.h"

namespace covey {
namespace {

Solution solve_elected(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed;
  distributed.dgnc.solver = pgo::RoundSolver::kElected;
  distributed.dgnc.dimension = graph.dimension;
  distributed.dgnc.barc2 = options.barc2;
  Solution solution = solve_as_team(pgo::robust_form(graph), distributed);
  solution.team->block_updates = 0;
  solution.team->rounds = 1;
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
