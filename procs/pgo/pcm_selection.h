// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The loops that agree with each other (core/pgo/pcm.h), for solvers that are to get no others.

#include "core/pgo/pcm.h"
#include "procs/pgo/solvers.h"

namespace covey {

struct PcmSelection {
  pgo::PcmResult pcm;
  pgo::PoseGraph graph;  // what was kept
};

// By the largest cliques; says so on stderr where the time for one was up and it may not be the largest.
PcmSelection select_consistent(const pgo::PoseGraph& graph, const SolverOptions& options);

// A solution of the selection as one of the whole graph: what PCM did not keep has weight 0, and is not kept whatever its r^2.
Solution of_whole_graph(Solution solution, const PcmSelection& selection, const pgo::PoseGraph& graph,
                        double barc2);

}  // namespace covey
