// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A random positive definite matrix of blocks of 1 to 6 rows, as BlockCholesky and as a dense matrix whose rows stand in the
// order of BlockCholesky.

#include <random>

#include "core/graph/block_cholesky.h"

namespace covey::graph::testing {

struct RandomBlocks {
  std::vector<int> sizes;
  std::vector<std::pair<int, int>> pairs;
};

inline RandomBlocks random_pattern(int variables, int loops, std::mt19937_64& random) {
  RandomBlocks pattern;
  for (int v = 0; v < variables; ++v) {
    pattern.sizes.push_back(1 + static_cast<int>(random() % 6));
    if (v > 0) pattern.pairs.emplace_back(v - 1, v);
  }
  for (int k = 0; k < loops; ++k) {
    const int i = static_cast<int>(random() % variables);
    const int j = static_cast<int>(random() % variables);
    if (i != j) pattern.pairs.emplace_back(i, j);
  }
  return pattern;
}

// Adds J^T J of a random J over the two variables of each pair, and a little on the diagonal; the same to `dense`.
inline void add_random_values(const RandomBlocks& pattern, BlockCholesky& matrix, Eigen::MatrixXd& dense,
                              std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto gaussian = [&](int rows, int columns) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }));
  };
  const auto add = [&](int i, int j, const Eigen::MatrixXd& block) {
    matrix.add(i, j, block);
    dense.block(matrix.first_row(i), matrix.first_row(j), block.rows(), block.cols()) += block;
    if (i != j)
      dense.block(matrix.first_row(j), matrix.first_row(i), block.cols(), block.rows()) += block.transpose();
  };
  for (const auto& [i, j] : pattern.pairs) {
    const Eigen::MatrixXd J_i = gaussian(4, pattern.sizes[i]);
    const Eigen::MatrixXd J_j = gaussian(4, pattern.sizes[j]);
    add(i, i, J_i.transpose() * J_i);
    add(j, j, J_j.transpose() * J_j);
    add(i, j, J_i.transpose() * J_j);
  }
  for (int v = 0; v < static_cast<int>(pattern.sizes.size()); ++v)
    add(v, v, 0.1 * Eigen::MatrixXd::Identity(pattern.sizes[v], pattern.sizes[v]));
}

}  // namespace covey::graph::testing
