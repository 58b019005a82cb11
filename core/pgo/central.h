// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Solvers that see the whole pose graph at once: what the distributed ones are compared with. Both go downhill from the
// start they are given (start.h) and leave the gauge where the start has it; the graph must be connected.

#include <functional>
#include <string>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct CentralResult {
  Poses poses;
  double cost = 0.0;            // by cost.h: least squares, or robust
  std::vector<double> weights;  // per edge, 0 or 1; all 1 for least squares
  int iterations = 0;           // Levenberg-Marquardt steps, all rounds together
  bool converged = false;
  std::string message;  // of the last solve
};

// Minimises cost(graph, poses) by Levenberg-Marquardt.
struct LeastSquaresOptions {
  int max_iterations = 200;
  double relative_cost_tolerance = 1e-11;
};
CentralResult solve_least_squares(const PoseGraph& graph, const Poses& start,
                                  const LeastSquaresOptions& options = {});

// Minimises robust_cost(graph, poses, barc2) by graduated non-convexity (core/graph/gnc.h).
struct RobustOptions {
  double barc2 =
      0.0;  // threshold of r^2; chi_square_quantile(probability, pose_degrees_of_freedom(dimension))
  double mu_step = 1.4;                  // growth of mu per round, as long as it is small
  std::function<void()> each_step = {};  // core/graph/solve.h
};
CentralResult solve_robust(const PoseGraph& graph, const Poses& start, const RobustOptions& options);

}  // namespace covey::pgo
