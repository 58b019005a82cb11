// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a robot can do before it speaks to others: solve each segment that comes from odometry alone by the loops within it, with
// outliers rejected (central.h). What drift has bent is then straight before frames are aligned and mu_0 is taken from the
// largest residual.

#include <vector>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/central.h"

namespace covey::pgo {

// starts[s] of segments[s]: replaced where its solution is 0 and loops have both ends in it. Its first pose stays.
void solve_odometry_starts(const GraphSnapshot& graph, const RobustOptions& options,
                           std::vector<SegmentStart>& starts);

}  // namespace covey::pgo
