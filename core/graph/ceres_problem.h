// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A graph and its values as a Ceres problem, for solves that eliminate one kind of variable first and then are dense
// (SolveOptions::eliminate_first). For core/graph's own sources only: nothing else includes Ceres.
//
// Factors give Jacobians in tangent spaces where Ceres wants them in ambient ones. Both are served by writing
// the tangent Jacobian into the first columns of the ambient one and telling Ceres that the derivative of
// plus is [I; 0]: their product, the only thing Ceres uses, is the tangent Jacobian.

#include <ceres/ceres.h>

#include <memory>
#include <vector>

#include "core/graph/solve.h"

namespace covey::graph {

class CeresProblem {
 public:
  // Both must outlive the problem; solve() writes into the values.
  CeresProblem(const Graph& graph, Values& values);
  ~CeresProblem();
  CeresProblem(const CeresProblem&) = delete;
  CeresProblem& operator=(const CeresProblem&) = delete;

  SolveResult solve(const SolveOptions& options);

 private:
  class Cost;
  class Loss;

  void add_variable(ceres::Problem& problem, Key key, VariableType type) const;
  std::unique_ptr<ceres::Problem> make_problem() const;
  std::shared_ptr<ceres::ParameterBlockOrdering> make_ordering(char first) const;

  const Graph& graph_;
  Values& values_;
  std::vector<double> scratch_;
  std::vector<std::unique_ptr<Cost>> costs_;                 // by FactorId, null where the graph has none
  std::vector<std::unique_ptr<Loss>> losses_;                // likewise, null without kernel
  std::vector<std::unique_ptr<ceres::Manifold>> manifolds_;  // by Space
};

}  // namespace covey::graph
