// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/solve.h"

#include "core/graph/ceres_problem.h"
#include "core/graph/sparse_problem.h"

namespace covey::graph {

SolveResult solve(const Graph& graph, Values& values, const SolveOptions& options) {
  COVEY_CHECK(options.eliminate_first != 0 || graph.held().size() == 0);
  if (options.eliminate_first != 0) return CeresProblem(graph, values).solve(options);
  return SparseProblem(graph, values).solve(options);
}

}  // namespace covey::graph
