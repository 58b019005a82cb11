// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/damped_system.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>

#include "tests/core/graph/random_blocks.h"

using namespace covey::graph;
using covey::graph::testing::add_random_values;
using covey::graph::testing::random_pattern;

namespace {

double relative_error(const Eigen::MatrixXd& H, const Eigen::VectorXd& b, const Eigen::VectorXd& x) {
  const Eigen::VectorXd exact = H.llt().solve(b);
  const Eigen::VectorXd e = x - exact;
  return std::sqrt(e.dot(H * e) / exact.dot(H * exact));
}

}  // namespace

TEST_CASE(
    "DampedSystem: exact at first, and close enough after small and after large changes of the matrix") {
  std::mt19937_64 random(3);
  const auto pattern = random_pattern(120, 400, random);
  DampedSystem system(BlockCholesky(pattern.sizes, pattern.pairs));
  const Eigen::Index rows = system.H.rows();
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(rows, rows);
  add_random_values(pattern, system.H, dense, random);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(rows);
  const Eigen::VectorXd damping = 0.01 * dense.diagonal();
  const auto damped = [&] { return Eigen::MatrixXd(dense + Eigen::MatrixXd(damping.asDiagonal())); };
  auto x = system.solve(b, damping);
  REQUIRE(x);
  REQUIRE(relative_error(damped(), b, *x) < 1e-10);

  for (const double change : {1.02, 50.0}) {
    system.H.add(7, 7,
                 (change - 1.0) * dense.block(system.H.first_row(7), system.H.first_row(7), pattern.sizes[7],
                                              pattern.sizes[7]));
    dense.block(system.H.first_row(7), system.H.first_row(7), pattern.sizes[7], pattern.sizes[7]) *= change;
    x = system.solve(b, damping);
    REQUIRE(x);
    REQUIRE(relative_error(damped(), b, *x) < 0.03);
  }

  system.H.set_zero();
  dense.setZero();
  add_random_values(pattern, system.H, dense, random);
  x = system.solve(b, damping);
  REQUIRE(x);
  REQUIRE(relative_error(damped(), b, *x) < 0.03);
}

TEST_CASE("DampedSystem: without a positive definite sum there is no solution, with more damping there is") {
  DampedSystem system(BlockCholesky({1, 1}, {{0, 1}}));
  const Eigen::Matrix<double, 1, 1> one(1.0);
  system.H.add(0, 0, one);
  system.H.add(1, 1, one);
  system.H.add(0, 1, 2.0 * one);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(2);
  REQUIRE_FALSE(system.solve(b, Eigen::VectorXd::Constant(2, 0.5)));
  const auto x = system.solve(b, Eigen::VectorXd::Constant(2, 2.0));
  REQUIRE(x);
  REQUIRE((*x)(0) == Approx(0.2));
}
