// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/central.h"
#include "core/pgo/start.h"
#include "procs/pgo/solvers.h"

namespace covey {
namespace {

Solution from_central(pgo::CentralResult result) {
  Solution solution;
  solution.poses = std::move(result.poses);
  solution.iterations = result.iterations;
  solution.converged = result.converged;
  solution.weights = std::move(result.weights);
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

}  // namespace

std::vector<Solver> central_solvers() {
  return {
      {"l2", "central least squares from a chordal start", false, solve_l2},
      {"gnc", "central graduated non-convexity from odometry, robots aligned robustly", true, solve_gnc},
      {"gnc-naive", "the same, robots aligned by one random loop each", true, solve_gnc_naive},
  };
}

}  // namespace covey
