// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/solution.h"

#include <algorithm>
#include <utility>

namespace covey::pgo {
namespace {

// Where weights are binary from the first, mu is infinite; as a number that a message may have it is large enough for that.
constexpr double kLargestMu = 1e9;

std::map<Utime, std::vector<SE3>> placed(std::vector<SegmentResult> segments) {
  std::map<Utime, std::vector<SE3>> poses;
  for (SegmentResult& segment : segments) {
    if (segment.placed) poses[segment.segment] = std::move(segment.T_W_K);
  }
  return poses;
}

}  // namespace

Solution solution_of(const RoundResult& result) {
  return {result.name, result.frame, result.graph, 0.0, result.robots, placed(result.segments)};
}

Solution unfinished_solution_of(const DgncRound& round) {
  return {round.name(), round.frame(),          round.graph(), std::min(round.mu(), kLargestMu),
          {},           placed(round.current())};
}

std::vector<SegmentStart> starts_from(const Solution& solution, const GraphSnapshot& graph) {
  std::vector<SegmentStart> starts;
  for (const Segment& segment : graph.segments) {
    SegmentStart start;
    const auto known = solution.segments.find(segment.name);
    if (known != solution.segments.end() && !known->second.empty()) {
      start.solution = solution.frame;
      start.T_S_K = known->second;
      start.T_S_K.resize(std::min(start.T_S_K.size(), segment.poses.size()));
    } else {
      start.T_S_K = {segment.poses.front().T_O_K};
    }
    while (start.T_S_K.size() < segment.poses.size()) {
      start.T_S_K.push_back(start.T_S_K.back() * segment.poses[start.T_S_K.size()].T_P_K);
    }
    starts.push_back(std::move(start));
  }
  return starts;
}

}  // namespace covey::pgo
