// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where the robots of a team drive: walks through the streets of a town or the rooms of a floor, on the right-hand side, that meet. Routes are drawn robot after
// robot; of many random walks that do not turn back, each robot takes the one that shares most lane with every robot before it (same place
// and same direction, at another time), drives some lane of its own twice, meets early, and sees most that nobody else sees. Of several such teams the best is taken.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/sim/mesh_world.h"

namespace covey::sim {

struct RouteOptions {
  std::vector<double> lengths_m = {60.0, 60.0, 60.0};  // per robot, in one and the same time
  std::uint64_t seed = 1;
  double lane_m = 0.25;    // of the lane from the street's centre line
  double shared_m = 10.0;  // with each other robot: more is not sought
  double again_m = 7.0;    // driven twice by one robot, likewise
  double headway_m = 5.0;  // between two robots on one street
  int teams = 8;           // that are drawn, the best is taken; fewer for long routes
  int candidates = 1500;   // per robot of each, likewise
};

// Corners in W on the ground z = 0, per robot. The road graph must have streets, and from every junction a way on.
std::vector<std::vector<Eigen::Vector3d>> choose_routes(const RoadGraph& roads, const RouteOptions& options);

}  // namespace covey::sim
