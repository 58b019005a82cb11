// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/central.h"
#include "core/pgo/start.h"
#include "procs/pgo/pcm_selection.h"
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

pgo::Poses start_of(const pgo::PoseGraph& graph, const SolverOptions& options, const std::string& usual) {
  const std::string& start = options.start.empty() ? usual : options.start;
  if (start == "chordal") return pgo::chordal_start(graph);
  if (start == "odometry") return pgo::odometry_start(graph);
  // A robot that only one loop ties to the others still has to lie somewhere.
  return pgo::robust_start(graph, {.min_inliers = 1}).poses;
}

Solution solve_l2(const pgo::PoseGraph& graph, const SolverOptions& options) {
  return from_central(pgo::solve_least_squares(graph, start_of(graph, options, "chordal")));
}

Solution solve_gnc(const pgo::PoseGraph& graph, const SolverOptions& options) {
  return from_central(pgo::solve_robust(graph, start_of(graph, options, "robust"), {.barc2 = options.barc2}));
}

Solution solve_gnc_naive(const pgo::PoseGraph& graph, const SolverOptions& options) {
  return from_central(
      pgo::solve_robust(graph, pgo::naive_start(graph, options.seed), {.barc2 = options.barc2}));
}

Solution solve_pcm(const pgo::PoseGraph& graph, const SolverOptions& options) {
  const PcmSelection selection = select_consistent(graph, options);
  const pgo::PoseGraph form = pgo::robust_form(selection.graph);
  Solution solution = of_whole_graph(from_central(pgo::solve_least_squares(form, pgo::chordal_start(form))),
                                     selection, graph, options.barc2);
  solution.kept = selection.pcm.kept;  // PCM decides alone
  return solution;
}

// As in the paper, section VI-A: with PCM, robots are aligned by random loops among those that it kept.
Solution solve_pcm_gnc(const pgo::PoseGraph& graph, const SolverOptions& options) {
  const PcmSelection selection = select_consistent(graph, options);
  return of_whole_graph(solve_gnc_naive(selection.graph, options), selection, graph, options.barc2);
}

}  // namespace

std::vector<Solver> central_solvers() {
  return {
      {"l2", "central least squares from a chordal start", false, solve_l2, true},
      {"pcm", "least squares over the largest sets of loops that agree pairwise", true, solve_pcm},
      {"gnc", "central graduated non-convexity from odometry, robots aligned robustly", true, solve_gnc,
       true},
      {"gnc-naive", "the same, robots aligned by one random loop each", true, solve_gnc_naive},
      {"pcm+gnc", "gnc-naive over the loops that pcm keeps", true, solve_pcm_gnc},
  };
}

}  // namespace covey
