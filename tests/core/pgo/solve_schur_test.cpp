// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/solve_schur.h"

#include <catch2/catch.hpp>

#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/start.h"
#include "tests/core/pgo/worlds.h"

using namespace covey;
using namespace covey::pgo;

TEST_CASE("second-order steps of a team end at the central optimum") {
  for (const int dimension : {2, 3}) {
    const Walk walk = make_walk({.dimension = dimension, .poses = 300, .rotation_sigma = 0.03});
    const CentralResult central = solve_least_squares(walk.graph, chordal_start(walk.graph));
    for (const int robots : {1, 2, 5}) {
      const PoseGraph graph = cut_into_robots(walk.graph, robots);
      const SolveSchurResult result = solve_schur(graph, chordal_start(graph));
      CHECK(result.converged);
      CHECK(result.rounds <= 12);
      CHECK(result.block_updates == result.rounds * robots);
      CHECK(result.cost == Approx(central.cost).epsilon(1e-9));
      CHECK(result.cost == Approx(cost(graph, result.poses)));
      CHECK((result.bytes.empty()) == (robots == 1));
      CHECK(result.poses[0].translation.norm() < 1e-3);  // the gauge is that of the start
    }
  }
}

TEST_CASE("costs of a team fall from step to step, from a bad start too") {
  const Walk walk = make_walk({.poses = 200, .rotation_sigma = 0.05});
  const PoseGraph graph = cut_into_robots(walk.graph, 3);
  Poses start = chordal_start(graph);
  for (std::size_t k = 0; k < start.size(); ++k) {
    Vector6d d;
    d << std::sin(1.0 * k), std::cos(2.0 * k), std::sin(3.0 * k), 0.5 * std::sin(5.0 * k),
        0.5 * std::cos(7.0 * k), 0.5 * std::sin(11.0 * k);
    start[k] = start[k] * SE3::exp(d);
  }
  const SolveSchurResult result = solve_schur(graph, start);
  CHECK(result.converged);
  CHECK(std::is_sorted(result.costs.rbegin(), result.costs.rend()));
  CHECK(result.cost < 0.1 * cost(graph, start));
}

TEST_CASE("robots that share nothing are each solved where they are") {
  const Walk walk = make_walk({.poses = 120});
  PoseGraph graph = cut_into_robots(walk.graph, 2);
  std::erase_if(graph.edges, [](const Edge& edge) { return edge.between_robots(); });
  graph.poses_per_robot.push_back(0);
  graph.poses_per_robot.push_back(1);
  Poses start = odometry_start(graph);
  start.back().translation.x() = 7.0;
  const SolveSchurResult result = solve_schur(graph, start);
  CHECK(result.converged);
  CHECK(result.separating_poses == 0);
  CHECK(result.poses.back().translation.x() == 7.0);
  double alone = 0.0;
  for (const int robot : {0, 1}) {
    PoseGraph part{3, {60}, {}};
    for (Edge edge : graph.edges) {
      if (edge.from.robot != robot) continue;
      edge.from.robot = edge.to.robot = 0;
      part.edges.push_back(edge);
    }
    alone += solve_least_squares(part, odometry_start(part)).cost;
  }
  CHECK(result.cost == Approx(alone).epsilon(1e-9));
}

TEST_CASE("a team stops when it is told to") {
  const Walk walk = make_walk({.poses = 100, .rotation_sigma = 0.05});
  const PoseGraph graph = cut_into_robots(walk.graph, 2);
  SolveSchurOptions options;
  int asked = 0;
  options.stop = [&](const std::function<Poses()>& poses) {
    CHECK(poses().size() == 100);
    return ++asked == 2;
  };
  const SolveSchurResult result = solve_schur(graph, odometry_start(graph), options);
  CHECK(asked == 2);
  CHECK(result.rounds == 2);
}
