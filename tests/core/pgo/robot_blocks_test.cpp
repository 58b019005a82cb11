// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/robot_blocks.h"

#include <catch2/catch.hpp>

#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "tests/core/pgo/worlds.h"

namespace covey::pgo {
namespace {

PoseGraph team(int robots, int seed, int dimension = 3) {
  return cut_into_robots(make_walk({.dimension = dimension, .poses = 120, .grid = 4, .seed = seed}).graph,
                         robots);
}

std::vector<Lifted> lifted_blocks(const std::vector<RobotBlock>& blocks, const Poses& poses) {
  std::vector<Lifted> X;
  for (const RobotBlock& block : blocks) {
    X.emplace_back(block.solver.rank(), 4 * block.solver.poses());
    for (int k = 0; k < block.solver.poses(); ++k)
      X.back().middleCols<4>(4 * k) = lift(poses[block.first + k], block.solver.rank());
  }
  return X;
}

std::vector<Lifted> public_parts(const std::vector<RobotBlock>& blocks, const std::vector<Lifted>& X) {
  std::vector<Lifted> parts;
  for (std::size_t b = 0; b < blocks.size(); ++b) parts.push_back(public_part(blocks[b], X[b]));
  return parts;
}

TEST_CASE("private edges and half of the shared ones make up the team's cost") {
  for (int seed = 1; seed <= 5; ++seed) {
    const Walk walk = make_walk({.poses = 120, .grid = 4, .seed = seed});
    PoseGraph graph = cut_into_robots(walk.graph, 4);
    graph.poses_per_robot.insert(graph.poses_per_robot.begin() + 1, 0);  // a robot without poses
    for (Edge& edge : graph.edges) {
      for (PoseId* end : {&edge.from, &edge.to}) end->robot += end->robot > 0 ? 1 : 0;
    }
    const std::vector<RobotBlock> blocks = split_into_blocks(graph, 5, {});
    REQUIRE(blocks.size() == 4);
    const std::vector<Lifted> X = lifted_blocks(blocks, walk.truth);
    const std::vector<Lifted> known = public_parts(blocks, X);
    double sum = 0.0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const Lifted targets = targets_of(blocks[b], known);
      sum += blocks[b].solver.edge_residuals(X[b]).sum() +
             0.5 * blocks[b].solver.shared_residuals(targets, X[b]).sum();
    }
    REQUIRE(sum == Approx(cost(graph, walk.truth)));
  }
}

TEST_CASE("a block's gradient is the team's, seen along its own poses") {
  const PoseGraph graph = team(3, 7);
  const std::vector<RobotBlock> blocks = split_into_blocks(graph, 3, {});
  const Walk walk = make_walk({.poses = 120, .grid = 4, .seed = 7});
  const std::vector<Lifted> X = lifted_blocks(blocks, walk.truth);
  const std::vector<Lifted> known = public_parts(blocks, X);
  for (const RobotBlock& block : blocks) {
    const auto b = static_cast<std::size_t>(block.robot);
    const Lifted gradient = block.solver.riemannian_gradient(targets_of(block, known), X[b]);
    for (const int k : {0, 5, block.solver.poses() - 1}) {
      for (int axis = 0; axis < 6; ++axis) {
        const double h = 1e-5;
        Vector6d xi = Vector6d::Zero();
        xi[axis] = h;
        Poses ahead = walk.truth;
        Poses behind = walk.truth;
        SE3& T = ahead[block.first + k];
        const Eigen::Matrix3d R = T.rotation.matrix();
        T = T * SE3::exp(xi);
        behind[block.first + k] = behind[block.first + k] * SE3::exp(-xi);
        const double numeric = (cost(graph, ahead) - cost(graph, behind)) / (2.0 * h);
        const double along =
            axis < 3 ? R.col(axis).dot(gradient.col(4 * k + 3))
                     : (R * hat(xi.tail<3>() / h)).cwiseProduct(gradient.middleCols<3>(4 * k)).sum();
        REQUIRE(along == Approx(numeric).epsilon(1e-5).margin(1e-3));
      }
    }
  }
}

TEST_CASE("neighbours have different colours, and no more are used than needed at most") {
  for (int seed = 1; seed <= 10; ++seed) {
    const std::vector<RobotBlock> blocks = split_into_blocks(team(2 + seed, seed), 3, {});
    const std::vector<int> colours = colours_of(blocks);
    std::size_t most = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      for (const int other : blocks[b].neighbours) REQUIRE(colours[b] != colours[other]);
      most = std::max(most, blocks[b].neighbours.size());
    }
    for (const int colour : colours) REQUIRE((colour >= 0 && colour <= static_cast<int>(most)));
  }
}

TEST_CASE("a team in a row needs two colours") {
  PoseGraph graph{3, {2, 2, 2, 2, 2}, {}};
  for (int robot = 0; robot < 5; ++robot) {
    graph.edges.push_back({{robot, 0}, {robot, 1}, {}});
    if (robot > 0) graph.edges.push_back({{robot - 1, 1}, {robot, 0}, {}});
  }
  const std::vector<int> colours = colours_of(split_into_blocks(graph, 3, {}));
  REQUIRE(*std::max_element(colours.begin(), colours.end()) == 1);
}

}  // namespace
}  // namespace covey::pgo
