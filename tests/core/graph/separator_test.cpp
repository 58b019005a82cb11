// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/separator.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "core/graph/linearise.h"
#include "tests/core/graph/worlds.h"

using namespace covey;
using namespace covey::graph;
using covey::graph::testing::make_ring;
using covey::graph::testing::pose_key;
using covey::graph::testing::RingWorld;

namespace {

// The step of the whole graph from its normal equations, with `weight` on the loops.
Eigen::VectorXd full_step(const RingWorld& world, const Values& values, double weight, double damping) {
  const Linearisation model = linearise(world.graph, values);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(model.J.rows());
  for (const FactorId id : world.loops) weights.segment(model.first_row.at(id), 6).setConstant(weight);
  const Eigen::MatrixXd J = model.J;
  Eigen::MatrixXd H = J.transpose() * weights.asDiagonal() * J;
  H.diagonal() += damping * H.diagonal();
  return H.ldlt().solve(-J.transpose() * weights.asDiagonal() * model.r);
}

Eigen::VectorXd difference(const Values& after, const Values& before) {
  Eigen::VectorXd d(6 * (RingWorld::kPoses - 1));
  for (int k = 1; k < RingWorld::kPoses; ++k) {
    minus(after.type(pose_key(k)), after.data(pose_key(k)), before.data(pose_key(k)), d.data() + 6 * (k - 1));
  }
  return d;
}

}  // namespace

TEST_CASE("reducing, solving for the kept and going back is the step of the whole graph") {
  for (const double weight : {1.0, 0.3, 0.0}) {
    for (const std::vector<Key>& kept :
         {std::vector<Key>{}, {pose_key(7)}, {pose_key(3), pose_key(20), pose_key(39)}}) {
      const RingWorld world = make_ring(10);
      Separator separator(world.graph, world.start, kept);
      for (const FactorId id : world.loops) separator.set_weight(id, weight);
      const double damping = 1e-4;
      REQUIRE(separator.factorise(world.start, damping));
      const Separator::Reduction reduction = separator.reduce(world.start);
      CHECK(reduction.cost == Approx(separator.cost(world.start)));
      const Eigen::MatrixXd S = separator.schur().selfadjointView<Eigen::Lower>();
      const Eigen::VectorXd d = S.ldlt().solve(reduction.b);
      Values moved = world.start;
      separator.move(d, moved);
      const Eigen::VectorXd step = full_step(world, world.start, weight, damping);
      CHECK((difference(moved, world.start) - step).cwiseAbs().maxCoeff() < 1e-9);
    }
  }
}

TEST_CASE("with an old factor the right-hand side is still that of the values") {
  const RingWorld world = make_ring(0);
  const std::vector<Key> kept = {pose_key(5), pose_key(25)};
  Separator separator(world.graph, world.start, kept);
  REQUIRE(separator.factorise(world.start, 1e-9));
  Values values = world.start;
  double cost = separator.cost(values);
  for (int round = 0; round < 40; ++round) {
    const Separator::Reduction reduction = separator.reduce(values);
    const Eigen::MatrixXd S = separator.schur().selfadjointView<Eigen::Lower>();
    separator.move(S.ldlt().solve(reduction.b), values);
    CHECK(separator.cost(values) <= cost * (1.0 + 1e-12));
    cost = separator.cost(values);
  }
  const Separator::Reduction last = separator.reduce(values);
  CHECK(last.gain < 1e-9 * cost);
  CHECK(separator.schur().selfadjointView<Eigen::Lower>().toDenseMatrix().ldlt().solve(last.b).norm() < 1e-5);
}

TEST_CASE("a kept variable without factors is part of the system, and a graph that floats is damped") {
  Graph graph;
  Values values;
  for (int k = 0; k < 4; ++k) values.set(pose_key(k), SE3{});
  for (int k = 0; k < 2; ++k) {
    graph.add(ChordalBetween3{SE3{SO3{}, {1.0, 0.0, 0.0}}, 1.0, 1.0}, {pose_key(k), pose_key(k + 1)});
  }
  Separator separator(graph, values, {pose_key(2), pose_key(3)});
  REQUIRE(separator.factorise(values, 1e-8));
  CHECK(separator.schur().rows() == 12);
  CHECK(separator.schur().diagonal().minCoeff() > 0.0);
  const Eigen::VectorXd b = separator.reduce(values).b;
  CHECK(b.tail(6).norm() == 0.0);
  separator.move(Eigen::VectorXd::Zero(12), values);
  CHECK(separator.cost(values) < 1e-6);
}
