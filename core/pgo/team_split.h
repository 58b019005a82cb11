// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A team's pose graph as its robots hold it, and the poses that they find as those of the graph: what solving in one process takes.
//
// Each robot's poses that consecutive odometry edges join are a segment, named by 1 + the index of its first pose; further
// odometry edges between the same poses become loops with weight 1. A loop's key is the index of its edge.

#include <map>
#include <optional>
#include <vector>

#include "core/pgo/dgnc_round.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct TeamMember {
  GraphSnapshot graph;
  std::vector<SegmentStart> starts;
  std::vector<int> first;  // index of each segment's first pose among the robot's
};

// One entry per robot with poses. start: in one frame; without it, each segment starts from its odometry.
std::map<int, TeamMember> split_team(const PoseGraph& graph, const std::optional<Poses>& start);

// In flat order; identity for segments without poses.
Poses gather_poses(const PoseGraph& graph, const std::map<int, TeamMember>& team,
                   const std::map<int, std::vector<SegmentResult>>& segments);
// Per pose: its segment is placed.
std::vector<bool> gather_placed(const PoseGraph& graph, const std::map<int, TeamMember>& team,
                                const std::map<int, std::vector<SegmentResult>>& segments);

}  // namespace covey::pgo
