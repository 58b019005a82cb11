// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Makes multi-robot and outlier experiments from one robot's graph, by definitions that tables can be
// compared with.

#include <cstdint>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

// Cuts a graph of one robot into `robots` contiguous ranges of poses, equal up to one pose: robot r has the
// poses from floor(r n / N) to floor((r + 1) n / N). Flat indices stay. Odometry across a cut becomes a loop
// between robots, and no known inlier. 1 <= robots <= poses.
PoseGraph cut_into_robots(const PoseGraph& graph, int robots);

// Adds round(n_loops share / (1 - share)) random loops, so that `share` (0 <= share < 1) of all loops are
// wrong: between random poses of different robots (with one robot: between any two that do not follow each
// other), rotation uniform, each coordinate of the translation uniform in [-10, 10] m, with the median kappa
// and tau of the loops that are there (of all edges when there are none). The same seed gives the same loops.
struct Injection {
  PoseGraph graph;            // the new loops stand last
  std::vector<bool> is_true;  // per edge
};
Injection inject_outliers(const PoseGraph& graph, double share, std::uint64_t seed);

}  // namespace covey::pgo
