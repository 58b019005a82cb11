// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a team's solution of a pose graph is worth: its robust cost (CONVENTIONS.md), and how its loop
// closures were told apart, by the weights that the solver gave them or, without those, by which residuals
// stay below the threshold.

#include <optional>
#include <vector>

#include "core/eval/loops.h"
#include "core/pgo/cost.h"
#include "core/pgo/pose_graph.h"

namespace covey {

struct GraphSolution {
  pgo::Poses poses;
  std::optional<std::vector<bool>> kept;  // per edge; nothing: decided by the residuals
};

struct GraphScore {
  pgo::RobustCost robust;
  std::vector<JudgedClosure> closures;  // the graph's loops, in its order
  LoopScore loops;
};

// truth: poses in any frame; nothing where it is not known.
GraphScore score_graph(const pgo::PoseGraph& graph, const GraphSolution& solution, double barc2,
                       const std::optional<pgo::Poses>& truth = std::nullopt,
                       const ClosureLimits& limits = {});

}  // namespace covey
