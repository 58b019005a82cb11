// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where the robots of a team drive: walks through the streets of a town, on the right-hand side, that meet. Routes are drawn robot after
// robot; of many random walks that do not turn back, each robot takes the one that shares most lane with every robot before it (same place
// and same direction, at another time), drives some lane of its own twice, meets early, and sees most that nobody else sees.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/sim/mesh_world.h"

namespace covey::sim {

struct RouteOptions {
  int robots = 3;
  double length_m = 60.0;  // of every route, at least
  std::uint64_t seed = 1;
  double lane_m = 0.8;     // of the lane from the street's centre line
  double shared_m = 10.0;  // with each other robot, and with itself: more is not sought
  double headway_m = 5.0;  // between two robots on one lane
  int candidates = 3000;   // per robot; fewer for long routes
};

// Corners in W on the ground z = 0, per robot. The road graph must have streets, and from every junction a way on.
std::vector<std::vector<Eigen::Vector3d>> choose_routes(const RoadGraph& roads, const RouteOptions& options);

}  // namespace covey::sim
