// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Solutions of a pose graph as trajectories, one per robot, and back. Poses of a graph have no stamps; by
// agreement pose `index` was taken at keyframe_utime(index), in files, on buses and in evaluations alike.

#include <vector>

#include "core/geometry/trajectory.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

constexpr Utime keyframe_utime(int index) { return kUsPerSecond * (1 + static_cast<Utime>(index)); }

std::vector<Trajectory> to_trajectories(const PoseGraph& graph, const Poses& poses);

// `robots`: one trajectory per robot of the graph. Stamps that are none of the robot's are left out;
// InputError names the first pose that has none.
Poses from_trajectories(const PoseGraph& graph, const std::vector<Trajectory>& robots);

}  // namespace covey::pgo
