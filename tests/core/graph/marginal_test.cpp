// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/marginal.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/graph/linearise.h"
#include "core/graph/solve.h"
#include "tests/core/graph/factor_testing.h"
#include "tests/core/graph/worlds.h"

using namespace covey;
using namespace covey::graph;
using graph::testing::jacobian_error;
using graph::testing::make_ring;
using graph::testing::pose_key;

namespace {

std::vector<Key> pose_keys(int first, int last) {
  std::vector<Key> keys;
  for (int k = first; k < last; ++k) keys.push_back(pose_key(k));
  return keys;
}

// b - a = measured
struct Step {
  using Variables = VariableList<Vector<2>, Vector<2>>;
  static constexpr int kDim = 2;
  Eigen::Vector2d measured = Eigen::Vector2d::Zero();
  Eigen::Vector2d evaluate(const Vector<2>& a, const Vector<2>& b, Eigen::Matrix2d* J_a,
                           Eigen::Matrix2d* J_b) const {
    if (J_a) *J_a = -Eigen::Matrix2d::Identity();
    if (J_b) J_b->setIdentity();
    return b - a - measured;
  }
};

// Of a only the first coordinate is seen.
struct FirstOnly {
  using Variables = VariableList<Vector<3>, Vector<1>>;
  static constexpr int kDim = 2;
  Eigen::Vector2d evaluate(const Vector<3>& a, const Vector<1>& b, Eigen::Matrix<double, 2, 3>* J_a,
                           Eigen::Matrix<double, 2, 1>* J_b) const {
    if (J_a) {
      *J_a << 1.0, 0.0, 0.0, 0.0, 0.0, 0.0;
      *J_b << -1.0, 1.0;
    }
    return {a.x() - b(0), b(0) - 7.0};
  }
};

// Linear factors between vectors: there a marginal is exact.
Graph linear_chain(Values& values) {
  Graph graph;
  covey::testing::RandomGeometry random;
  for (std::uint64_t k = 0; k < 6; ++k) values.set({'v', k}, random.vector<2>());
  graph.add(Prior<Vector<2>>{random.vector<2>()}, {{'v', 0}}, Noise<2>::sigma(0.5));
  for (std::uint64_t k = 1; k < 6; ++k) graph.add(Step{random.vector<2>()}, {{'v', k - 1}, {'v', k}});
  graph.add(Step{random.vector<2>()}, {{'v', 0}, {'v', 5}}, Noise<2>::sigma(0.3));
  graph.add(Step{random.vector<2>()}, {{'v', 1}, {'v', 4}}, Noise<2>::sigma(2.0));
  return graph;
}

}  // namespace

TEST_CASE("Marginalise: of a linear graph the rest keeps its solution, information and cost differences") {
  Values values;
  const Graph full = linear_chain(values);
  Graph reduced = full;
  Values kept = values;
  const auto id = marginalise_out(reduced, kept, {{'v', 0}, {'v', 2}, {'v', 3}});
  REQUIRE(id.has_value());
  REQUIRE(kept.size() == 3);
  REQUIRE(reduced.keys() == std::vector<Key>{{'v', 1}, {'v', 4}, {'v', 5}});

  const auto covariance_full = marginal_covariance(full, values, {{'v', 4}, {'v', 1}});
  const auto covariance_reduced = marginal_covariance(reduced, kept, {{'v', 4}, {'v', 1}});
  REQUIRE((*covariance_full - *covariance_reduced).norm() < 1e-10);

  const SolveOptions exact{.relative_cost_tolerance = 0.0};
  const double full_cost = solve(full, values, exact).final_cost;
  const double reduced_cost = solve(reduced, kept, exact).final_cost;
  REQUIRE(reduced_cost <= full_cost + 1e-12);  // the constant part of the cost is left out of the prior
  for (const Key key : kept.keys()) {
    REQUIRE((kept.get<Vector<2>>(key) - values.get<Vector<2>>(key)).norm() < 1e-8);
  }
}

TEST_CASE("Marginalise: at the solution of a nonlinear graph the rest is at rest") {
  const auto world = make_ring(0);
  Values solution = world.start;
  solve(world.graph, solution);
  Graph reduced = world.graph;
  Values kept = solution;
  const auto id = marginalise_out(reduced, kept, pose_keys(5, 15));
  REQUIRE(id.has_value());
  const Values before = kept;
  solve(reduced, kept);
  for (const Key key : kept.keys()) {
    REQUIRE((before.get<SE3>(key).inverse() * kept.get<SE3>(key)).log().norm() < 1e-5);
  }
  const auto covariance_full = marginal_covariance(world.graph, solution, {pose_key(30)});
  const auto covariance_reduced = marginal_covariance(reduced, before, {pose_key(30)});
  REQUIRE((*covariance_full - *covariance_reduced).norm() < 1e-6 * covariance_full->norm());
}

TEST_CASE("Marginalise: the prior's Jacobians hold away from its linearisation point") {
  covey::testing::RandomGeometry random;
  const auto world = make_ring(0);
  const auto prior = marginalise(world.graph, world.start, pose_keys(3, 6));
  REQUIRE(prior != nullptr);
  Values moved = world.start;
  for (const Key key : prior->keys()) moved.perturb(key, random.vector<6>(0.3));
  REQUIRE(jacobian_error(*prior, moved) < 1e-6);
  REQUIRE(jacobian_error(*prior, world.start) < 1e-6);
}

TEST_CASE("Marginalise: undetermined directions are dropped, not divided by") {
  Graph graph;
  Values values;
  values.set({'v', 0}, Vector<3>(1.0, 2.0, 3.0));
  values.set({'v', 1}, Vector<1>(1.0));
  graph.add(FirstOnly{}, {{'v', 0}, {'v', 1}});
  const auto prior = marginalise(graph, values, {{'v', 0}});
  REQUIRE(prior != nullptr);
  REQUIRE(prior->residual_dim() == 1);
  REQUIRE(std::abs(prior->jacobian()(0, 0)) == Approx(1.0));
  REQUIRE(std::abs(prior->offset()(0)) == Approx(6.0));
}

TEST_CASE("Marginalise: variables that share nothing with the rest leave no prior") {
  Graph graph;
  Values values;
  values.set({'v', 0}, Vector<2>(1.0, 2.0));
  values.set({'v', 1}, Vector<2>(1.0, 2.0));
  graph.add(Prior<Vector<2>>{Vector<2>::Zero()}, {{'v', 0}});
  graph.add(Prior<Vector<2>>{Vector<2>::Zero()}, {{'v', 1}});
  REQUIRE_FALSE(marginalise_out(graph, values, {{'v', 0}}).has_value());
  REQUIRE(graph.size() == 1);
  REQUIRE(values.size() == 1);
}

TEST_CASE("Covariance: agrees with the dense inverse, and is refused without gauge") {
  auto world = make_ring(0);
  const Linearisation model = linearise(world.graph, world.start);
  const Eigen::MatrixXd J(model.J);
  const Eigen::MatrixXd inverse = (J.transpose() * J).inverse();
  const auto covariance = marginal_covariance(world.graph, world.start, {pose_key(20), pose_key(3)});
  REQUIRE(covariance.has_value());
  std::vector<int> columns;
  for (const int pose : {20, 3}) {
    for (int c = 0; c < 6; ++c) columns.push_back(model.first_column.at(pose_key(pose)) + c);
  }
  REQUIRE((*covariance - inverse(columns, columns)).norm() < 1e-8 * covariance->norm());
  world.graph.set_constant(pose_key(0), false);
  REQUIRE_FALSE(marginal_covariance(world.graph, world.start, {pose_key(20)}).has_value());
}

namespace {

// Poses and points as in a small reconstruction, where points share no factors.
struct Seen {
  using Variables = VariableList<SE3, Vector<3>>;
  static constexpr int kDim = 3;
  Eigen::Vector3d measured = Eigen::Vector3d::Zero();
  Occasion occasion = {};
  Eigen::Vector3d evaluate(const SE3& T, const Vector<3>& p, Eigen::Matrix<double, 3, 6>* J_T,
                           Eigen::Matrix3d* J_p) const {
    const Eigen::Vector3d q = T.inverse() * Eigen::Vector3d(p);
    if (J_T) {
      *J_T << -Eigen::Matrix3d::Identity(), hat(q);
      *J_p = T.rotation.matrix().transpose();
    }
    return q - measured;
  }
};

constexpr std::uint64_t kViews = 5;
constexpr std::uint64_t kPoints = 20;

Graph reconstruction(Values& values) {
  covey::testing::RandomGeometry random(3);
  Graph graph;
  for (std::uint64_t pose = 0; pose < kViews; ++pose) {
    values.set({'x', pose}, SE3::exp(random.vector<6>(0.3)));
    if (pose > 0) graph.add(Between<SE3>{SE3::exp(random.vector<6>(0.3))}, {{'x', pose - 1}, {'x', pose}});
  }
  graph.add(Prior<SE3>{SE3{}}, {{'x', 0}}, Noise<6>::sigma(0.1));
  for (std::uint64_t point = 0; point < kPoints; ++point) {
    values.set({'l', point}, Vector<3>(random.vector<3>(2.0)));
    for (std::uint64_t pose = point % 2; pose < kViews; ++pose)
      graph.add(Seen{random.vector<3>(2.0), {static_cast<int>(pose % 2), 0.2 * static_cast<double>(pose)}},
                {{'x', pose}, {'l', point}}, {}, Robust::huber(1.5));
  }
  return graph;
}

}  // namespace

TEST_CASE("Marginals: with points eliminated first they are those of the whole graph") {
  Values values;
  const Graph graph = reconstruction(values);
  const DenseMarginals marginals(graph, values, 'l');
  for (const std::vector<Key>& keys : {std::vector<Key>{{'x', 4}}, std::vector<Key>{{'x', 3}, {'x', 1}}}) {
    const auto expected = marginal_covariance(graph, values, keys);
    const auto found = marginals.covariance(keys);
    REQUIRE(expected);
    REQUIRE(found);
    REQUIRE((*found - *expected).norm() < 1e-9 * expected->norm());
  }
  Graph loose = graph;
  for (const FactorId id : graph.ids()) {
    if (graph.factor(id).keys().size() == 1) loose.remove(id);
  }
  REQUIRE_FALSE(DenseMarginals(loose, values, 'l').covariance({{'x', 4}}));
}

TEST_CASE("Marginals: errors that hang together, also through a prior") {
  SharedError shared{.variance = 3.0, .share = 0.7, .memory_s = 0.5};
  for (std::uint64_t pose = 0; pose < kViews; ++pose)
    shared.common[{'x', pose}] = Eigen::MatrixXd::Random(6, 2) * 0.1 * static_cast<double>(pose);
  Values values;
  Graph graph = reconstruction(values);
  const Linearisation model = linearise(graph, values);
  const Eigen::MatrixXd J(model.J);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(J.rows(), J.rows());
  Eigen::MatrixXd off = Eigen::MatrixXd::Zero(J.rows(), 2);
  for (const auto& [i, row] : model.first_row) {
    const Factor& a = graph.factor(i);
    if (a.keys().back().kind != 'l') continue;
    off.middleRows(row, 3) =
        J.block(row, model.first_column.at(a.keys()[0]), 3, 6) * shared.common.at(a.keys()[0]);
    for (const auto& [j, column] : model.first_row) {
      const Factor& b = graph.factor(j);
      if (b.keys().back() != a.keys().back() || b.occasion()->series != a.occasion()->series) continue;
      const double apart_s = std::abs(a.occasion()->time_s - b.occasion()->time_s);
      const double correlation = i == j ? 1.0 : 0.7 * std::exp(-apart_s / 0.5);
      covariance.block<3, 3>(row, column).diagonal().setConstant(3.0 * correlation);
    }
  }
  covariance += off * off.transpose();
  const Eigen::MatrixXd H_inverse = (J.transpose() * J).inverse();
  const Eigen::MatrixXd C = H_inverse * J.transpose() * covariance * J * H_inverse;
  const Eigen::MatrixXd expected =
      C.block<6, 6>(model.first_column.at({'x', 4}), model.first_column.at({'x', 4}));
  const auto found = DenseMarginals(graph, values, 'l', shared).covariance({{'x', 4}});
  REQUIRE(found);
  REQUIRE((*found - expected).norm() < 1e-9 * expected.norm());

  // In two steps, so that the first prior goes into the second.
  std::vector<Key> leaving{{'x', 0}};
  for (std::uint64_t point = 0; point < kPoints; ++point) leaving.push_back({'l', point});
  for (const std::vector<Key>& removed : {leaving, std::vector<Key>{{'x', 1}}})
    REQUIRE(marginalise_out(graph, values, removed, 'l', shared));
  const auto after = DenseMarginals(graph, values, 'l', shared).covariance({{'x', 4}});
  REQUIRE(after);
  REQUIRE((*after - expected).norm() < 1e-6 * expected.norm());
}

TEST_CASE("marginalise: points eliminated first give the same prior, and constant poses are conditioned on") {
  for (const bool constant : {false, true}) {
    Values values;
    Graph graph = reconstruction(values);
    graph.set_constant({'x', 2}, constant);
    std::vector<Key> removed{{'x', 0}};
    for (std::uint64_t point = 0; point < kPoints; point += 3) removed.push_back({'l', point});
    for (std::uint64_t point = 0; point < kPoints; ++point) {
      if (point % 3 == 0) continue;
      for (const FactorId id : graph.ids_touching({{'l', point}})) {
        if (graph.factor(id).keys().front() == Key{'x', 0}) graph.remove(id);
      }
    }
    const auto expected = marginalise(graph, values, removed);
    const auto found = marginalise(graph, values, removed, 'l');
    REQUIRE(found->keys() == expected->keys());
    const Eigen::MatrixXd H = expected->jacobian().transpose() * expected->jacobian();
    REQUIRE((found->jacobian().transpose() * found->jacobian() - H).norm() < 1e-9 * H.norm());
    const Eigen::VectorXd b = expected->jacobian().transpose() * expected->offset();
    REQUIRE((found->jacobian().transpose() * found->offset() - b).norm() < 1e-9 * b.norm());
    const bool has = std::count(found->keys().begin(), found->keys().end(), Key{'x', 2}) == 1;
    REQUIRE(has != constant);
  }
}
