// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a robot keeps of a round, finished or not: enough to begin the next one from.

#include <cstdint>
#include <map>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/se3.h"
#include "core/pgo/dgnc_round.h"
#include "core/pgo/robot_graph.h"
#include "core/pgo/round_message.h"

namespace covey::pgo {

struct Solution {
  RoundName round;
  std::int64_t frame = 0;                      // name of W; 0 for none
  std::uint64_t graph = 0;                     // hash of what was solved
  double mu = 0.0;                             // where an unfinished round stood; 0 for a finished one
  std::vector<int> robots;                     // that are in W, ascending; none where the round is unfinished
  std::map<Utime, std::vector<SE3>> segments;  // T_W_K of the placed ones
};

Solution solution_of(const RoundResult& result);
// Of a round that has come to updates and not to its end.
Solution unfinished_solution_of(const DgncRound& round);

// Of each segment of the graph: as the solution has it, with newer keyframes chained on by odometry; in its odometry frame
// where the solution has none of it.
std::vector<SegmentStart> starts_from(const Solution& solution, const GraphSnapshot& graph);

}  // namespace covey::pgo
