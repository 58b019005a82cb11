// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "core/pgo/start.h"
#include "procs/pgo/pcm_selection.h"
#include "procs/pgo/solvers.h"
#include "procs/pgo/team_solution.h"

namespace covey {
namespace {

Solution solve_dgnc(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed;
  distributed.dgnc.barc2 = options.barc2;
  return solve_as_team(pgo::robust_form(graph), distributed);
}

Solution solve_dgnc_naive(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed;
  distributed.dgnc.barc2 = options.barc2;
  distributed.start = pgo::naive_start(graph, options.seed);
  return solve_as_team(pgo::robust_form(graph), distributed);
}

// PCM is pairwise, so two robots can do it by themselves; what they would tell each other for it is counted.
Solution solve_pcm_dgnc(const pgo::PoseGraph& graph, const SolverOptions& options) {
  const PcmSelection selection = select_consistent(graph, options);
  Solution solution = solve_dgnc_naive(selection.graph, options);
  solution.team->bytes_sent += pgo::exchange_bytes(selection.pcm);
  return of_whole_graph(std::move(solution), selection, graph, options.barc2);
}

}  // namespace

std::vector<Solver> dgnc_solvers() {
  return {
      {"dgnc", "a team's graduated non-convexity over rbcd, robots aligned robustly", true, solve_dgnc},
      {"dgnc-naive", "the same, robots aligned by one random loop each", true, solve_dgnc_naive},
      {"pcm+dgnc", "dgnc-naive over the loops that pcm keeps", true, solve_pcm_dgnc},
  };
}

}  // namespace covey
