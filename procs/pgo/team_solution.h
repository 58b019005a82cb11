// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// solve_distributed (core/pgo) as a Solution; its warnings go to stderr.

#include "core/pgo/solve_distributed.h"
#include "procs/pgo/solvers.h"

namespace covey {

Solution solve_as_team(const pgo::PoseGraph& graph, const pgo::DistributedOptions& options);

}  // namespace covey
