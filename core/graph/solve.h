// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Nonlinear least squares: moves the values of a graph's variables to a local minimum of its cost by
// Levenberg-Marquardt with a sparse Cholesky factorisation, on one thread. Values that no factor touches and
// constant ones stay. A graph without gauge (no prior, nothing constant) is solved too; then only differences
// mean something. Every key of the graph must be in the values (COVEY_CHECK). Values or measurements that are
// not finite, or a cost that cannot be lowered, are reported in the result; they are never an error and leave
// the values as they were.

#include <functional>
#include <string>

#include "core/graph/graph.h"

namespace covey::graph {

struct SolveOptions {
  int max_iterations = 100;
  double relative_cost_tolerance = 1e-9;  // stop when a step lowers the cost by less than this part of it
  double gradient_tolerance = 1e-10;      // largest entry of the gradient of half the cost
  double initial_trust_radius = 1e6;      // 1 / the first damping; 1e4 is more careful, for starts far away
  // Variables of this kind (Key::kind), no two of which share a factor, are eliminated first, and the system of the others is
  // solved as a dense one: for many small variables that hang on a few large ones, as landmarks do on poses. 0: sparse.
  char eliminate_first = 0;
  // Called before each step, for who must not be silent for as long as a solve takes; not with eliminate_first.
  std::function<void()> each_step = {};
};

struct SolveResult {
  double initial_cost = 0.0;  // sum of rho(|r|^2), no factor 1/2, over all factors
  double final_cost = 0.0;
  int iterations = 0;  // steps tried
  bool converged = false;
  std::string message;
};

SolveResult solve(const Graph& graph, Values& values, const SolveOptions& options = {});

}  // namespace covey::graph
