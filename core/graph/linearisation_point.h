// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where a factor of a graph is linearised: at the values, but for variables that are held (Graph::hold). With x_0 the point and x the values, the first-order
// model is
//
//   r(x * Exp(d)) = r(x) + J(x_0) M d,   M = minus_jacobian(x, x_0) of each held variable and I of the others
//
// so that a perturbation means the same to all factors of a variable, linear priors among them.

#include <vector>

#include "core/graph/graph.h"

namespace covey::graph {

class LinearisationPoint {
 public:
  // The graph must outlive it and keep its held variables.
  LinearisationPoint(const Graph& graph, const Factor& factor);

  // As Factor::evaluate.
  void evaluate(const double* const* x, double* residual, double* const* jacobians) const;

 private:
  const Factor& factor_;
  std::vector<const double*> held_;         // of each variable, or null; empty: of none
  mutable std::vector<const double*> x_0_;  // memory that is used again
};

}  // namespace covey::graph
