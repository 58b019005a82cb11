// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/block_cholesky.h"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <random>

namespace covey::pgo {
namespace {

template <int B>
struct System {
  using Block = Eigen::Matrix<double, B, B>;

  // Diagonally dominant, with each pair of 0 ... n-1 joined by chance, some of them twice and the other way round.
  System(int n, std::uint64_t seed) : diagonal(n) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto draw = [&] { return Block(Block::NullaryExpr([&] { return uniform(random); })); };
    dense = Eigen::MatrixXd::Zero(n * B, n * B);
    for (int i = 0; i < n; ++i) {
      const Block block = draw();
      diagonal[i] = block * block.transpose() + 4.0 * n * B * Block::Identity();
      dense.block<B, B>(B * i, B * i) = diagonal[i];
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        if (i == j || random() % 4 != 0) continue;
        pairs.emplace_back(i, j);
        off_diagonal.push_back(draw());
        dense.block<B, B>(B * i, B * j) += off_diagonal.back();
        dense.block<B, B>(B * j, B * i) += off_diagonal.back().transpose();
      }
    }
    x = Eigen::MatrixXd::NullaryExpr(n * B, 3, [&] { return uniform(random); });
  }
  std::vector<Block> diagonal;
  std::vector<Block> off_diagonal;
  std::vector<std::pair<int, int>> pairs;
  Eigen::MatrixXd dense;
  Eigen::MatrixXd x;
};

TEMPLATE_TEST_CASE_SIG("a block factor solves what a dense one solves", "", ((int B), B), 4, 6) {
  for (int trial = 0; trial < 20; ++trial) {
    const int n = 1 + 2 * trial;
    const System<B> system(n, trial + 1);
    BlockCholesky<B> factor(n, system.pairs);
    REQUIRE(factor.factorise(system.diagonal, system.off_diagonal));
    Eigen::MatrixXd x = system.x;
    factor.solve(x);
    REQUIRE((system.dense * x - system.x).norm() < 1e-12 * system.dense.norm());
  }
}

TEST_CASE("the pattern outlives the values") {
  System<6> system(12, 3);
  BlockCholesky<6> factor(12, system.pairs);
  REQUIRE(factor.factorise(system.diagonal, system.off_diagonal));
  for (auto& block : system.diagonal) block *= 2.0;
  for (auto& block : system.off_diagonal) block *= 2.0;
  REQUIRE(factor.factorise(system.diagonal, system.off_diagonal));
  Eigen::MatrixXd x = system.x;
  factor.solve(x);
  REQUIRE((2.0 * system.dense * x - system.x).norm() < 1e-12 * system.dense.norm());
}

TEST_CASE("what is not positive definite is not factorised") {
  System<4> system(8, 5);
  system.diagonal[5](2, 2) = -1.0;
  BlockCholesky<4> factor(8, system.pairs);
  REQUIRE_FALSE(factor.factorise(system.diagonal, system.off_diagonal));
}

}  // namespace
}  // namespace covey::pgo
