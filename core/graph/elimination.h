// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A sparse symmetric matrix whose unknowns stand in two groups, an interior that is eliminated and a boundary that stays,
// with a diagonal D that changes from one factorisation to the next:
//
//   A + D = [ A_ii + D_i   A_ib      ]         complement = A_bb + D_b - A_bi (A_ii + D_i)^-1 A_ib
//           [ A_bi         A_bb + D_b ]
//
// A + D is positive definite exactly where A_ii + D_i and the complement are (Haynsworth, "Determination of the inertia of a
// partitioned Hermitian matrix", 1968), which two owners can find out about their own parts. The order of elimination is
// found once.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace covey::graph {

class Elimination {
 public:
  // lower: the lower triangle of A; its first `interior` unknowns are eliminated, which may be none or all.
  Elimination(int interior, const Eigen::SparseMatrix<double>& lower);
  ~Elimination();
  Elimination(Elimination&&) noexcept;

  // D has the size of A. False where A_ii + D_i is not positive definite; then nothing below may be asked for.
  bool factorise(const Eigen::VectorXd& D);

  // (A_ii + D_i)^-1 B
  Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const;
  Eigen::MatrixXd complement() const;
  // A_bi, with one column for each interior unknown.
  const Eigen::SparseMatrix<double>& coupling() const { return A_bi_; }

 private:
  class Cholesky;
  Eigen::SparseMatrix<double> A_ii_;  // lower triangle with every diagonal entry, as A_bb_
  Eigen::SparseMatrix<double> A_bi_;
  Eigen::SparseMatrix<double> A_bb_;
  Eigen::VectorXd D_b_;
  std::unique_ptr<Cholesky> cholesky_;
};

}  // namespace covey::graph
