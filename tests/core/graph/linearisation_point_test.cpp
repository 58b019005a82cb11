// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/linearisation_point.h"

#include <catch2/catch.hpp>

#include "core/graph/linearise.h"
#include "core/graph/marginal.h"
#include "tests/core/graph/worlds.h"

using namespace covey;
using namespace covey::graph;
using graph::testing::make_ring;
using graph::testing::pose_key;
using graph::testing::RingWorld;

namespace {

// A ring that hangs on nothing.
Graph loose_ring(const RingWorld& world) {
  Graph graph = world.graph;
  graph.set_constant(pose_key(0), false);
  return graph;
}

void move_all(Values& values, double sigma, covey::testing::RandomGeometry& random) {
  for (const Key key : values.keys()) values.perturb(key, random.vector<6>(sigma));
}

}  // namespace

TEST_CASE("Held: Jacobians stay where the variable was held, residuals follow the values") {
  covey::testing::RandomGeometry random;
  const auto world = make_ring(0);
  Graph graph = loose_ring(world);
  for (int k = 0; k < RingWorld::kPoses; ++k) graph.hold(pose_key(k), world.start);
  Values moved = world.start;
  move_all(moved, 0.1, random);
  graph.hold(pose_key(3), moved);  // stays where it is held already

  const Linearisation there = linearise(world.graph, world.start);
  const Linearisation free = linearise(loose_ring(world), moved);
  const Linearisation held = linearise(graph, moved);
  CHECK((held.r - free.r).norm() < 1e-9);
  // Differences from the points d = minus(x, x_0) and perturbations of the values are related by M.
  const int column = held.first_column.at(pose_key(3));
  const VariableType type = moved.type(pose_key(3));
  const Eigen::MatrixXd M = minus_jacobian(type, moved.data(pose_key(3)), world.start.data(pose_key(3)));
  const Eigen::MatrixXd expected =
      Eigen::MatrixXd(there.J).middleCols(there.first_column.at(pose_key(3)), 6) * M;
  CHECK((Eigen::MatrixXd(held.J).middleCols(column, 6) - expected).norm() < 1e-9 * expected.norm());

  graph.release(pose_key(3));
  CHECK_FALSE(graph.held().has(pose_key(3)));
}

TEST_CASE(
    "Held: priors upon priors know nothing of where the whole is, however the values move between them") {
  covey::testing::RandomGeometry random;
  const auto world = make_ring(0);
  Graph graph = loose_ring(world);
  Values values = world.start;
  const LinearPrior* prior = nullptr;
  for (int first = 0; first < 30; first += 5) {
    std::vector<Key> leaving;
    for (int k = first; k < first + 5; ++k) leaving.push_back(pose_key(k));
    const auto id = marginalise_out(graph, values, leaving);
    REQUIRE(id);
    prior = dynamic_cast<const LinearPrior*>(&graph.factor(*id));
    for (const Key key : prior->keys()) graph.hold(key, values);
    move_all(values, 0.05, random);
  }
  REQUIRE(prior != nullptr);
  Eigen::MatrixXd N(prior->jacobian().cols(), 6);
  for (std::size_t k = 0; k < prior->keys().size(); ++k) {
    const SE3 T = graph.held().get<SE3>(prior->keys()[k]);
    N.middleRows<6>(6 * static_cast<Eigen::Index>(k)) = T.inverse().adjoint();
  }
  CHECK((prior->jacobian() * N).norm() < 1e-6 * prior->jacobian().norm());
}
