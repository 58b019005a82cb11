// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/solvers.h"

#include <fmt/format.h>

#include <cstdio>
#include <ctime>

#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/solve_distributed.h"
#include "core/pgo/start.h"

namespace covey {
namespace {

Solution from_central(pgo::CentralResult result) {
  Solution solution;
  solution.poses = std::move(result.poses);
  solution.iterations = result.iterations;
  solution.converged = result.converged;
  return solution;
}

Solution solve_l2(const pgo::PoseGraph& graph, const SolverOptions&) {
  return from_central(pgo::solve_least_squares(graph, pgo::chordal_start(graph)));
}

Solution solve_gnc(const pgo::PoseGraph& graph, const SolverOptions& options) {
  // A robot that only one loop ties to the others still has to lie somewhere.
  const pgo::RobustStart start = pgo::robust_start(graph, {.min_inliers = 1});
  return from_central(pgo::solve_robust(graph, start.poses, {.barc2 = options.barc2}));
}

Solution solve_gnc_naive(const pgo::PoseGraph& graph, const SolverOptions& options) {
  return from_central(
      pgo::solve_robust(graph, pgo::naive_start(graph, options.seed), {.barc2 = options.barc2}));
}

Solution from_team(const pgo::PoseGraph& graph, const pgo::DistributedOptions& options) {
  pgo::DistributedResult result = pgo::solve_distributed(graph, options);
  for (const std::string& warning : result.warnings) fmt::print(stderr, "pgo: {}\n", warning);
  Solution solution;
  solution.poses = std::move(result.poses);
  solution.iterations = result.updates;
  solution.team = Solution::Team{result.block_updates, result.updates, 0, 0.0};
  for (const auto& [type, bytes] : result.bytes) solution.team->bytes_sent += bytes;
  return solution;
}

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
  Solution solution = from_team(graph, distributed);
  solution.team->watch_seconds = static_cast<double>(watching) / CLOCKS_PER_SEC;
  return solution;
}

Solution solve_dgnc(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed;
  distributed.dgnc.barc2 = options.barc2;
  return from_team(pgo::robust_form(graph), distributed);
}

Solution solve_dgnc_naive(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::DistributedOptions distributed;
  distributed.dgnc.barc2 = options.barc2;
  distributed.start = pgo::naive_start(graph, options.seed);
  return from_team(pgo::robust_form(graph), distributed);
}

}  // namespace

const std::vector<Solver>& all_solvers() {
  static const std::vector<Solver> kSolvers = {
      {"l2", "central least squares from a chordal start", false, solve_l2},
      {"gnc", "central graduated non-convexity from odometry, robots aligned robustly", true, solve_gnc},
      {"gnc-naive", "the same, robots aligned by one random loop each", true, solve_gnc_naive},
      {"rbcd", "a team's least squares by block-coordinate descent, from a chordal start", false, solve_rbcd},
      {"dgnc", "a team's graduated non-convexity over rbcd, robots aligned robustly", true, solve_dgnc},
      {"dgnc-naive", "the same, robots aligned by one random loop each", true, solve_dgnc_naive},
  };
  return kSolvers;
}

}  // namespace covey
