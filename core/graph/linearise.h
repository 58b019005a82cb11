// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A graph's first-order model at given values: r(x * Exp(d)) = r + J d, |.|^2 the cost near x (robust kernels
// enter as the weights of iteratively reweighted least squares, r and J scaled by sqrt(rho')). Constant
// variables have no columns.

#include <Eigen/SparseCore>
#include <map>

#include "core/graph/graph.h"

namespace covey::graph {

struct Linearisation {
  Eigen::SparseMatrix<double> J;
  Eigen::VectorXd r;
  std::map<Key, int> first_column;    // of each variable, in key order
  std::map<FactorId, int> first_row;  // of each factor, in id order
};

Linearisation linearise(const Graph& graph, const Values& values);

}  // namespace covey::graph
