// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Sparse Cholesky factorisation P A P^T = L L^T of a symmetric positive definite matrix of B x B blocks, one block row to a
// pose. Ordering, fill and storage are by poses instead of scalars: AMD sees a graph B^2 times smaller, and all arithmetic is
// on blocks whose size the compiler knows. Left-looking; the pattern is analysed once and outlives changes of values.
//
// Sources: Davis, "Direct Methods for Sparse Linear Systems", 2006, chapter 4; Amestoy, Davis, Duff, "An Approximate Minimum
// Degree Ordering Algorithm", 1996.

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace covey::pgo {

template <int B>
class BlockCholesky {
 public:
  using Block = Eigen::Matrix<double, B, B>;

  // n block rows; pairs (i, j), i != j, of block rows that may be joined off the diagonal. A pair may stand there again.
  BlockCholesky(int n, const std::vector<std::pair<int, int>>& pairs);

  // A(i, i) = diagonal[i] and A(i, j) = the sum of off_diagonal[e] over all e with pairs[e] = (i, j), or transposed with (j, i).
  // False where A is not positive definite to working precision; then there is nothing to solve with.
  bool factorise(const std::vector<Block>& diagonal, const std::vector<Block>& off_diagonal);

  // A^-1 x for each column of x (n B rows), in place.
  void solve(Eigen::MatrixXd& x) const;

 private:
  int n_;
  std::vector<int> place_;  // when a block row is eliminated
  std::vector<int>
      starts_;  // of each column's blocks below the diagonal, in the order of elimination; one more at the end
  std::vector<int> rows_;  // of these blocks, ascending within a column
  std::vector<std::pair<int, bool>>
      slots_;  // where each pair's block stands among them, and whether transposed
  std::vector<Block> below_;
  std::vector<Block> inverse_diagonal_;  // of L's diagonal blocks
};

extern template class BlockCholesky<4>;
extern template class BlockCholesky<6>;

}  // namespace covey::pgo
