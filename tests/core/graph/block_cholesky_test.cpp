// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/block_cholesky.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <set>

#include "tests/core/graph/random_blocks.h"

using namespace covey::graph;
using covey::graph::testing::add_random_values;
using covey::graph::testing::random_pattern;

TEST_CASE("BlockCholesky: product, diagonal and solution are those of the dense matrix") {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto pattern = random_pattern(2 + 3 * trial, trial, random);
    BlockCholesky matrix(pattern.sizes, pattern.pairs);
    for (int round = 0; round < 2; ++round) {  // the second with other values in the same pattern
      Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(matrix.rows(), matrix.rows());
      matrix.set_zero();
      add_random_values(pattern, matrix, dense, random);
      const Eigen::MatrixXd B = Eigen::MatrixXd::Random(matrix.rows(), 3);
      REQUIRE((matrix.times(B.col(0)) - dense * B.col(0)).norm() < 1e-10);
      REQUIRE((matrix.diagonal() - dense.diagonal()).norm() < 1e-12);
      REQUIRE(matrix.factorise());
      REQUIRE((matrix.solve(B) - dense.llt().solve(B)).norm() < 1e-8);
      const Eigen::VectorXd damping = dense.diagonal();
      REQUIRE(matrix.factorise(damping));
      dense.diagonal() += damping;
      REQUIRE((matrix.solve(B) - dense.llt().solve(B)).norm() < 1e-8);
      REQUIRE((matrix.diagonal() + damping - dense.diagonal()).norm() < 1e-12);  // damping stays outside
    }
  }
}

TEST_CASE("BlockCholesky: every variable has its own rows, and a block's place is found from either side") {
  std::mt19937_64 random(2);
  const auto pattern = random_pattern(30, 40, random);
  BlockCholesky matrix(pattern.sizes, pattern.pairs);
  std::set<Eigen::Index> rows;
  for (int v = 0; v < 30; ++v) {
    for (int k = 0; k < pattern.sizes[v]; ++k) rows.insert(matrix.first_row(v) + k);
  }
  REQUIRE(static_cast<Eigen::Index>(rows.size()) == matrix.rows());
  REQUIRE(*rows.rbegin() == matrix.rows() - 1);
  for (const auto& [i, j] : pattern.pairs) {
    const BlockCholesky::Place a = matrix.place(i, j);
    const BlockCholesky::Place b = matrix.place(j, i);
    REQUIRE(a.first == b.first);
    REQUIRE(a.row_variable == b.row_variable);
    REQUIRE(matrix.first_row(a.row_variable) >= matrix.first_row(a.column_variable));
  }
}

TEST_CASE("BlockCholesky: what is not positive definite has no factor, and a moved matrix keeps its own") {
  const Eigen::Matrix2d I = Eigen::Matrix2d::Identity();
  BlockCholesky matrix({2, 2, 2}, {{0, 1}, {1, 0}, {1, 2}});
  REQUIRE_FALSE(matrix.factorise());
  for (int v = 0; v < 3; ++v) matrix.add(v, v, I);
  matrix.add(1, 0, 2.0 * I);
  REQUIRE_FALSE(matrix.factorise());
  REQUIRE(matrix.factorise(Eigen::VectorXd::Constant(6, 3.0)));
  const BlockCholesky moved = std::move(matrix);
  // [4 2; 2 4]^-1 [1; 1] = [1/6; 1/6], and 1/4 for the variable beside it.
  const Eigen::VectorXd x = moved.solve(Eigen::VectorXd::Ones(6));
  REQUIRE(x(moved.first_row(0)) == Approx(1.0 / 6.0));
  REQUIRE(x(moved.first_row(1)) == Approx(1.0 / 6.0));
  REQUIRE(x(moved.first_row(2)) == Approx(0.25));
}

TEST_CASE("BlockCholesky: without variables everything is empty") {
  BlockCholesky matrix({}, {});
  REQUIRE(matrix.rows() == 0);
  REQUIRE(matrix.factorise());
  REQUIRE(matrix.solve(Eigen::MatrixXd(0, 2)).size() == 0);
}
