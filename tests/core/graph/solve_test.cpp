// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/solve.h"

#include <catch2/catch.hpp>
#include <limits>

#include "core/graph/linearise.h"
#include "tests/core/graph/worlds.h"

using namespace covey;
using namespace covey::graph;
using graph::testing::make_ring;
using graph::testing::pose_key;
using graph::testing::worst_translation_error;

namespace {

// A point of the world, seen in the pose's frame.
struct PointSeen {
  using Variables = VariableList<SE3, Vector<3>>;
  static constexpr int kDim = 3;

  Eigen::Vector3d measured;

  Eigen::Vector3d evaluate(const SE3& T, const Eigen::Vector3d& p, Eigen::Matrix<double, 3, 6>* J_T,
                           Eigen::Matrix3d* J_p) const {
    const Eigen::Vector3d seen = T.inverse() * p;
    if (J_T) {
      *J_T << -Eigen::Matrix3d::Identity(), hat(seen);
      *J_p = T.rotation.matrix().transpose();
    }
    return seen - measured;
  }
};

}  // namespace

TEST_CASE("Solve: a ring with loops ends at a minimum near the truth") {
  const auto world = make_ring(0);
  Values values = world.start;
  const SolveResult result = solve(world.graph, values);
  REQUIRE(result.converged);
  REQUIRE(result.iterations > 0);
  REQUIRE(result.initial_cost == Approx(cost(world.graph, world.start)));
  REQUIRE(result.final_cost == Approx(cost(world.graph, values)));
  REQUIRE(result.final_cost < 0.5 * result.initial_cost);
  REQUIRE(worst_translation_error(values, world.truth) < 1.0);
  REQUIRE(worst_translation_error(values, world.truth) <
          0.7 * worst_translation_error(world.start, world.truth));
  const Linearisation model = linearise(world.graph, values);
  REQUIRE((model.J.transpose() * model.r).cwiseAbs().maxCoeff() < 1e-2);
}

TEST_CASE("Solve: constant variables and variables without factors stay to the last bit") {
  const auto world = make_ring(0);
  Values values = world.start;
  values.set({'z', 0}, SE3{});
  solve(world.graph, values);
  for (const Key key : {pose_key(0), Key{'z', 0}}) {
    const Values& before = key.kind == 'z' ? values : world.start;
    REQUIRE(std::equal(values.data(key), values.data(key) + 7, before.data(key)));
  }
  REQUIRE(values.get<SE3>({'z', 0}).matrix() == Eigen::Matrix4d::Identity());
}

TEST_CASE("Solve: the same input gives the same bits") {
  const auto world = make_ring(0);
  Values first = world.start;
  Values second = world.start;
  solve(world.graph, first);
  solve(world.graph, second);
  for (const Key key : first.keys())
    REQUIRE(std::equal(first.data(key), first.data(key) + 7, second.data(key)));
}

TEST_CASE("Solve: a graph without gauge is solved up to a motion") {
  auto world = make_ring(0);
  Values fixed = world.start;
  const double expected = solve(world.graph, fixed).final_cost;
  world.graph.set_constant(pose_key(0), false);
  Values free = world.start;
  REQUIRE(solve(world.graph, free).final_cost == Approx(expected));
}

TEST_CASE("Solve: every kind of variable in one graph, robust kernels hold an outlier off") {
  Graph graph;
  Values values;
  values.set({'p', 0}, SE2{0.3, {1.0, 2.0}});
  values.set({'r', 0}, SO3::exp({0.1, 0.2, 0.3}));
  values.set({'v', 0}, Vector<2>(5.0, 5.0));
  const SE2 pose{-2.0, {4.0, 4.0}};
  const SO3 rotation = SO3::exp({-0.5, 0.4, 1.0});
  graph.add(Prior<SE2>{pose}, {{'p', 0}});
  graph.add(Prior<SO3>{rotation}, {{'r', 0}});
  for (int k = 0; k < 5; ++k) graph.add(Prior<Vector<2>>{{1.0, 2.0}}, {{'v', 0}}, {}, Robust::cauchy(0.5));
  graph.add(Prior<Vector<2>>{{100.0, -100.0}}, {{'v', 0}}, {}, Robust::cauchy(0.5));
  const SolveResult result = solve(graph, values);
  REQUIRE(result.converged);
  REQUIRE((values.get<SE2>({'p', 0}).matrix() - pose.matrix()).norm() < 1e-6);
  REQUIRE((values.get<SO3>({'r', 0}).matrix() - rotation.matrix()).norm() < 1e-6);
  REQUIRE((values.get<Vector<2>>({'v', 0}) - Vector<2>(1.0, 2.0)).norm() < 0.05);
  REQUIRE(result.final_cost == Approx(cost(graph, values)));
}

TEST_CASE("Solve: what is not finite is reported and leaves the values alone") {
  Graph graph;
  Values values;
  values.set({'v', 0}, Vector<2>(5.0, 5.0));
  graph.add(Prior<Vector<2>>{{std::numeric_limits<double>::quiet_NaN(), 0.0}}, {{'v', 0}});
  const SolveResult result = solve(graph, values);
  REQUIRE_FALSE(result.converged);
  REQUIRE_FALSE(result.message.empty());
  REQUIRE(values.get<Vector<2>>({'v', 0}) == Vector<2>(5.0, 5.0));
}

TEST_CASE("Solve: an empty graph and one of constants only are solved at once") {
  Graph graph;
  Values values;
  REQUIRE(solve(graph, values).converged);
  values.set({'v', 0}, Vector<2>(3.0, 4.0));
  graph.add(Prior<Vector<2>>{Vector<2>::Zero()}, {{'v', 0}});
  graph.set_constant({'v', 0});
  const SolveResult result = solve(graph, values);
  REQUIRE(result.converged);
  REQUIRE(result.final_cost == Approx(25.0));
}

TEST_CASE("Linearise: r + J d is the first-order model, with kernels as weights") {
  covey::testing::RandomGeometry random;
  const auto world = make_ring(5);
  const Linearisation model = linearise(world.graph, world.start);
  REQUIRE(model.r.squaredNorm() == Approx(cost(world.graph, world.start)));
  REQUIRE(model.first_column.size() == world.truth.size() - 1);
  REQUIRE_FALSE(model.first_column.contains(pose_key(0)));

  constexpr double kStep = 1e-7;
  Values moved = world.start;
  Eigen::VectorXd d(model.J.cols());
  for (const auto& [key, column] : model.first_column) {
    d.segment<6>(column) = random.vector<6>();
    moved.perturb(key, kStep * d.segment<6>(column));
  }
  const Eigen::VectorXd difference = (linearise(world.graph, moved).r - model.r) / kStep;
  REQUIRE((difference - model.J * d).norm() < 1e-4 * difference.norm());

  Graph robust;
  Values values;
  values.set({'v', 0}, Vector<1>(10.0));
  robust.add(Prior<Vector<1>>{Vector<1>::Zero()}, {{'v', 0}}, {}, Robust::huber(2.0));
  const Linearisation weighted = linearise(robust, values);
  REQUIRE(weighted.J.coeff(0, 0) == Approx(std::sqrt(0.2)));
  REQUIRE(weighted.r(0) == Approx(10.0 * std::sqrt(0.2)));
}

TEST_CASE("Solve: eliminating small variables first ends where the sparse solve does") {
  covey::testing::RandomGeometry random(7);
  Graph graph;
  Values start;
  for (std::uint64_t pose = 0; pose < 6; ++pose) {
    start.set({'x', pose},
              SE3::exp(random.vector<6>(0.1)) * SE3{SO3{}, {static_cast<double>(pose), 0.0, 0.0}});
    if (pose > 0)
      graph.add(Between<SE3>{SE3{SO3{}, {1.0, 0.0, 0.0}}}, {{'x', pose - 1}, {'x', pose}},
                Noise<6>::sigma(0.3));
  }
  start.set({'x', 0}, SE3{});
  graph.set_constant({'x', 0});
  for (std::uint64_t point = 0; point < 40; ++point) {
    const Eigen::Vector3d p = random.vector<3>(4.0);
    start.set({'l', point}, Vector<3>(p + random.vector<3>()));
    for (std::uint64_t pose = 0; pose < 6; ++pose)
      graph.add(PointSeen{p - Eigen::Vector3d(static_cast<double>(pose), 0.0, 0.0) + random.vector<3>(0.5)},
                {{'x', pose}, {'l', point}}, {}, Robust::huber(2.0));
  }
  Values sparse = start;
  Values dense = start;
  const SolveResult expected = solve(graph, sparse);
  const SolveResult result = solve(graph, dense, {.eliminate_first = 'l'});
  REQUIRE(result.converged);
  REQUIRE(result.final_cost == Approx(expected.final_cost).epsilon(1e-6));
  for (const Key key : sparse.keys()) {
    if (key.kind == 'l') REQUIRE((sparse.get<Vector<3>>(key) - dense.get<Vector<3>>(key)).norm() < 1e-3);
  }
  // With none of that kind, or all of it constant, it is an ordinary solve.
  graph.set_constant({'x', 1});
  REQUIRE(solve(graph, dense, {.eliminate_first = 'q'}).converged);
}
