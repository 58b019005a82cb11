// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A symmetric positive definite matrix of small dense blocks, a few rows and columns for each variable, and its sparse
// Cholesky factor. The pattern is given once; values and factor change as often as wanted.
//
//   BlockCholesky H({6, 6, 6}, {{0, 1}, {1, 2}});   // rows of each variable; the pairs with a block off the diagonal
//   H.add(0, 1, J_0.transpose() * J_1);             // 6 x 6, which is its transpose's at (1, 0) too
//   if (H.factorise()) X = H.solve(B);              // variable v has the rows from first_row(v) of B and X
//
// Variables are eliminated in an order that keeps the factor sparse, found on the graph of the blocks: 36 times smaller than
// the matrix when they are 6 x 6, and so quick to order well. Rows stand in that order. Source: CHOLMOD (Chen, Davis, Hager,
// Rajamanickam, TOMS 35(3), 2008).

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

namespace covey::graph {

class BlockCholesky {
 public:
  // Pairs may be doubled and in either order. All values are zero at first.
  BlockCholesky(const std::vector<int>& sizes, const std::vector<std::pair<int, int>>& pairs);
  ~BlockCholesky();
  BlockCholesky(BlockCholesky&&) noexcept;
  BlockCholesky& operator=(BlockCholesky&&) noexcept;

  Eigen::Index rows() const { return rows_; }
  Eigen::Index first_row(int variable) const { return start_[position_[variable]]; }

  void set_zero();
  // Adds to the block of variables i and j and, when they differ, its transpose to that of j and i. A diagonal block must be
  // symmetric. The pair must be in the pattern (COVEY_CHECK).
  void add(int i, int j, const Eigen::Ref<const Eigen::MatrixXd>& block);

  // The one of a pair's two blocks that is stored, column-major in values() from `first`, its columns `stride` apart: for who
  // adds to the same blocks again and again. Of the diagonal ones all of the block is stored.
  struct Place {
    int row_variable = 0;
    int column_variable = 0;
    Eigen::Index first = 0;
    Eigen::Index stride = 0;
  };
  Place place(int i, int j) const;
  double* values() { return values_.data(); }

  Eigen::VectorXd diagonal() const;
  Eigen::VectorXd times(const Eigen::VectorXd& x) const;

  // The factor of the matrix, with `damping` added to its diagonal if there is any. False when it is not positive definite;
  // then there is no factor.
  bool factorise(const Eigen::VectorXd& damping = {});
  // With the last factor, whatever the values are now.
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const;
  // Floating-point operations of a factorisation over those of a solve.
  double solves_per_factorisation() const;

 private:
  struct Cholmod;

  Eigen::Index rows_ = 0;
  std::vector<int> position_;  // of each variable in the order of elimination
  std::vector<int> variable_;  // at each position
  std::vector<int> start_;     // by position: first row; and one entry more, rows_
  std::vector<std::vector<int>>
      below_;  // by position: the later ones with a block in its columns, increasing
  std::vector<Eigen::Index> first_value_;  // by position: of its columns
  std::vector<int> outer_;  // compressed columns of what is stored: the lower triangle and, of diagonal
  std::vector<int> inner_;  // blocks, the upper one too, which is never read
  Eigen::VectorXd values_;
  std::unique_ptr<Cholmod> cholmod_;
};

}  // namespace covey::graph
