// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/block_solver.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/geometry/stiefel.h"

namespace covey::pgo {
namespace {

class Generator {
 public:
  explicit Generator(std::uint64_t seed) : random_(seed) {}
  double normal(double sigma) { return sigma * normal_(random_); }
  SE3 pose(double rotation_sigma, double translation_sigma) {
    Vector6d xi;
    for (int i = 0; i < 3; ++i) xi[i] = normal(translation_sigma);
    for (int i = 3; i < 6; ++i) xi[i] = normal(rotation_sigma);
    return SE3::exp(xi);
  }
  Lifted matrix(int rows, int columns) {
    return Lifted::NullaryExpr(rows, columns, [this] { return normal(1.0); });
  }
  Lifted lifted(int rank, int poses) {
    Lifted X = 3.0 * matrix(rank, 4 * poses);
    for (int k = 0; k < poses; ++k) X.middleCols<3>(4 * k) = random_stiefel(rank, 3, random_);
    return X;
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

// A chain with a loop and three shared edges, weighted.
struct Problem {
  static std::vector<PrivateEdge> edges(Generator& generator, int poses) {
    std::vector<PrivateEdge> edges;
    for (int k = 0; k + 1 < poses; ++k) edges.push_back({k, k + 1, generator.pose(0.5, 1.0), 120.0, 35.0});
    edges.push_back({poses - 1, 0, generator.pose(1.0, 1.0), 50.0, 10.0});
    return edges;
  }
  static std::vector<SharedEdge> shared(Generator& generator, int poses) {
    std::vector<SharedEdge> shared;
    for (int e = 0; e < 3; ++e) {
      shared.push_back({e * (poses - 1) / 2, e % 2 == 0, generator.pose(1.0, 2.0), 80.0, 20.0});
    }
    return shared;
  }
  Problem(Generator& generator, int poses, int rank, const BlockSolverOptions& options = {})
      : solver(poses, rank, edges(generator, poses), shared(generator, poses), options), targets(rank, 12) {
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(poses);
    weights[poses - 1] = 0.3;
    solver.set_weights(weights, Eigen::Vector3d(1.0, 0.5, 2.0));
    const Lifted others = generator.lifted(rank, 3);
    for (int e = 0; e < 3; ++e) {
      targets.middleCols<4>(4 * e) = other_side(solver.shared()[e], others.middleCols<4>(4 * e));
    }
  }
  BlockSolver solver;
  Lifted targets;
};

TEST_CASE("the Riemannian gradient is that of the cost along the retraction") {
  Generator generator(1);
  for (const int rank : {3, 5}) {
    const Problem problem(generator, 6, rank);
    const Lifted X = generator.lifted(rank, 6);
    const Lifted gradient = problem.solver.riemannian_gradient(problem.targets, X);
    for (int trial = 0; trial < 20; ++trial) {
      Lifted V = generator.matrix(rank, 24);
      for (int k = 0; k < 6; ++k) {
        V.middleCols<3>(4 * k) = project_to_tangent(X.middleCols<3>(4 * k), V.middleCols<3>(4 * k));
      }
      const double h = 1e-5;
      const double numeric = (problem.solver.cost(problem.targets, retract(X, h * V)) -
                              problem.solver.cost(problem.targets, retract(X, -h * V))) /
                             (2.0 * h);
      REQUIRE(gradient.cwiseProduct(V).sum() == Approx(numeric).epsilon(1e-6).margin(1e-4));
    }
  }
}

TEST_CASE("the cost of lifted poses is the squared residual of the poses") {
  Generator generator(2);
  for (int trial = 0; trial < 20; ++trial) {
    const SE3 a = generator.pose(1.0, 3.0);
    const SE3 b = generator.pose(1.0, 3.0);
    const SE3 measured = generator.pose(1.0, 3.0);
    const SE3 predicted = a * measured;
    const double expected = 7.0 * (b.rotation.matrix() - predicted.rotation.matrix()).squaredNorm() +
                            3.0 * (b.translation - predicted.translation).squaredNorm();
    Lifted X(5, 8);
    X << lift(a, 5), lift(b, 5);
    const BlockSolver solver(2, 5, {{0, 1, measured, 7.0, 3.0}}, {});
    REQUIRE(solver.cost(Lifted(5, 0), X) == Approx(expected));
    const SharedEdge from{0, true, measured, 7.0, 3.0};
    const SharedEdge to{0, false, measured, 7.0, 3.0};
    REQUIRE(weighted_square(my_side(from, lift(a, 5)) - other_side(from, lift(b, 5)), 7.0, 3.0) ==
            Approx(expected));
    REQUIRE(weighted_square(my_side(to, lift(b, 5)) - other_side(to, lift(a, 5)), 7.0, 3.0) ==
            Approx(expected));
  }
}

TEST_CASE("a step never increases the cost, and repeated steps end where the gradient vanishes") {
  Generator generator(3);
  for (int trial = 0; trial < 20; ++trial) {
    Problem problem(generator, 12, trial % 2 == 0 ? 3 : 5);
    Lifted X = generator.lifted(problem.solver.rank(), 12);
    double cost = problem.solver.cost(problem.targets, X);
    BlockStep step;
    for (int i = 0; i < 30; ++i) {
      step = problem.solver.minimise(problem.targets, X);
      REQUIRE(step.cost_before == Approx(cost));
      REQUIRE(step.cost_after <= step.cost_before);
      cost = step.cost_after;
    }
    REQUIRE(step.gradient_after < 1e-4);
    for (int k = 0; k < 12; ++k) {
      const Lifted Y = X.middleCols<3>(4 * k);
      REQUIRE((Y.transpose() * Y - Eigen::Matrix3d::Identity()).norm() < 1e-10);
    }
  }
}

TEST_CASE("rows that are zero stay exactly zero") {
  Generator generator(4);
  Problem problem(generator, 8, 5);
  problem.targets.bottomRows<2>().setZero();
  Lifted X(5, 32);
  for (int k = 0; k < 8; ++k) X.middleCols<4>(4 * k) = lift(generator.pose(1.0, 2.0), 5);
  problem.solver.minimise(problem.targets, X);
  REQUIRE(X.bottomRows<2>().cwiseAbs().maxCoeff() == 0.0);
}

TEST_CASE("a stale preconditioner changes the speed, not the optimum") {
  Generator first(5);
  Generator second(5);
  Problem fresh(first, 10, 3, {.refactor_change = 0.0});
  Problem stale(second, 10, 3, {.refactor_change = 1e9});
  Lifted X = first.lifted(3, 10);
  Lifted Z = X;
  stale.solver.minimise(stale.targets, Z);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(10);
  weights[9] = 0.0;
  for (Problem* problem : {&fresh, &stale})
    problem->solver.set_weights(weights, Eigen::Vector3d(0.1, 3.0, 1.0));
  Z = X;
  for (int i = 0; i < 60; ++i) {
    fresh.solver.minimise(fresh.targets, X);
    stale.solver.minimise(stale.targets, Z);
  }
  REQUIRE(fresh.solver.cost(fresh.targets, X) == Approx(stale.solver.cost(stale.targets, Z)).epsilon(1e-9));
}

TEST_CASE("rounding returns what was lifted, whatever the gauge") {
  Generator generator(6);
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const SE3 anchor = generator.pose(1.0, 5.0);
    const SE3 other = generator.pose(1.0, 5.0);
    const Eigen::MatrixXd gauge = random_stiefel(5, 5, random);
    const SE3 rounded = round_to_pose(gauge * lift(anchor, 5), gauge * lift(other, 5));
    REQUIRE((anchor * rounded * other.inverse()).log().norm() < 1e-9);
  }
}

}  // namespace
}  // namespace covey::pgo
