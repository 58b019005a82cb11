// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>
#include <utility>

#include "core/pgo/cost.h"
#include "core/pgo/start.h"
#include "procs/pgo/pcm_selection.h"
#include "procs/pgo/solvers.h"
#include "procs/pgo/team_solution.h"

namespace covey {
namespace {

constexpr int kEarlyStop = 50;  // updates (Kimera-Multi, T-RO 2022, section VI)

pgo::DistributedOptions options_for(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed;
  distributed.dgnc.barc2 = options.barc2;
  distributed.dgnc.mu_step = options.mu_step;
  distributed.dgnc.alignment.dimension = graph.dimension;
  return distributed;
}

// Stops at --gap, by the robust cost.
Solution solve(const pgo::PoseGraph& graph, const SolverOptions& options,
               pgo::DistributedOptions distributed) {
  std::clock_t watching = 0;
  if (options.gap) {
    distributed.stop = [&](const pgo::DistributedProgress& progress) {
      const std::clock_t begin = std::clock();
      const double cost = pgo::robust_cost(graph, progress.poses(), options.barc2).cost;
      watching += std::clock() - begin;
      return cost <= *options.optimum * (1.0 + *options.gap);
    };
  }
  Solution solution = solve_as_team(pgo::robust_form(graph), distributed);
  solution.team->watch_seconds = static_cast<double>(watching) / CLOCKS_PER_SEC;
  return solution;
}

Solution solve_dgnc(const pgo::PoseGraph& graph, const SolverOptions& options) {
  return solve(graph, options, options_for(graph, options));
}

Solution solve_dgnc_naive(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed = options_for(graph, options);
  distributed.start = pgo::naive_start(graph, options.seed);
  return solve(graph, options, std::move(distributed));
}

Solution solve_dgnc_early(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed = options_for(graph, options);
  distributed.dgnc.total_updates = kEarlyStop;
  return solve(graph, options, std::move(distributed));
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
      {"dgnc", "a team's graduated non-convexity, robots aligned robustly; see --mu-step", true, solve_dgnc},
      {"dgnc-naive", "the same, robots aligned by one random loop each", true, solve_dgnc_naive},
      {"pcm+dgnc", "dgnc-naive over the loops that pcm keeps", true, solve_pcm_dgnc},
      {"dgnc-es", "dgnc that ends after 50 updates of each robot", true, solve_dgnc_early},
  };
}

}  // namespace covey
