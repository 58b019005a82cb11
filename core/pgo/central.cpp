// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/central.h"

#include "core/base/error.h"
#include "core/graph/gnc.h"
#include "core/graph/solve.h"
#include "core/pgo/cost.h"
#include "core/pgo/edge_factors.h"

namespace covey::pgo {
namespace {

// As good as no damping: from a chordal start Gauss-Newton's steps are good ones, and the soft directions of long chains are
// slowed by the least of it. A start far away only costs the few steps that are refused until there is enough.
constexpr double kTrustRadius = 1e12;

graph::Key pose_key(int flat) { return {'x', static_cast<std::uint64_t>(flat)}; }

// The factor graph with one factor per edge, in the same order, so that a factor's id is the edge's index; and the start.
struct Problem {
  Problem(const PoseGraph& pose_graph, const Poses& start) {
    COVEY_CHECK(static_cast<int>(start.size()) == pose_graph.poses());
    const std::vector<int> offsets = pose_graph.offsets();
    for (const Edge& edge : pose_graph.edges) {
      const graph::Key i = pose_key(offsets[edge.from.robot] + edge.from.index);
      const graph::Key j = pose_key(offsets[edge.to.robot] + edge.to.index);
      add_edge(factors, edge, pose_graph.dimension, i, j);
    }
    for (std::size_t k = 0; k < start.size(); ++k) {
      set_pose(values, pose_key(static_cast<int>(k)), start[k], pose_graph.dimension);
    }
    if (!start.empty()) factors.set_constant(pose_key(0));
  }

  Poses poses() const {
    Poses result;
    for (const graph::Key key : values.keys()) result.push_back(get_pose(values, key));
    return result;
  }

  graph::Graph factors;
  graph::Values values;
};

}  // namespace

CentralResult solve_least_squares(const PoseGraph& graph, const Poses& start,
                                  const LeastSquaresOptions& options) {
  Problem problem(graph, start);
  const graph::SolveResult solved = graph::solve(problem.factors, problem.values,
                                                 {.max_iterations = options.max_iterations,
                                                  .relative_cost_tolerance = options.relative_cost_tolerance,
                                                  .initial_trust_radius = kTrustRadius});
  CentralResult result{
      problem.poses(),  0.0,           std::vector<double>(graph.edges.size(), 1.0), solved.iterations,
      solved.converged, solved.message};
  result.cost = cost(graph, result.poses);
  return result;
}

CentralResult solve_robust(const PoseGraph& graph, const Poses& start, const RobustOptions& options) {
  Problem problem(robust_form(graph), start);
  graph::GncOptions gnc;
  gnc.barc_squared = options.barc2;
  gnc.mu_step = options.mu_step;
  gnc.annealing.each_step = gnc.last.each_step = options.each_step;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].known_inlier) gnc.candidates.push_back(e);
  }
  const graph::GncResult solved = graph::solve_gnc(problem.factors, problem.values, gnc);
  CentralResult result{
      problem.poses(),  0.0,           std::vector<double>(graph.edges.size(), 1.0), solved.iterations,
      solved.converged, solved.message};
  for (std::size_t k = 0; k < gnc.candidates.size(); ++k)
    result.weights[gnc.candidates[k]] = solved.weights[k];
  result.cost = robust_cost(graph, result.poses, options.barc2).cost;
  return result;
}

}  // namespace covey::pgo
