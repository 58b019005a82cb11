// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What D-GNC said of the loop closures of a pose graph, read from the logs of the robots' buses
// (LOOP_WEIGHTS).

#include <filesystem>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey {

// Per edge of the graph: true for odometry and for closures whose last weight is above one half. Both robots
// of a closure speak of it; the one with the lower id owns the weight, and is believed. Closures that no log
// speaks of were not kept.
std::vector<bool> kept_in_logs(const pgo::PoseGraph& graph, const std::vector<std::filesystem::path>& logs);

}  // namespace covey
