// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/elimination.h"

#include <Eigen/CholmodSupport>
#include <vector>

#include "core/base/error.h"

namespace covey::graph {

using Sparse = Eigen::SparseMatrix<double>;

class Elimination::Cholesky : public Eigen::CholmodSupernodalLLT<Sparse, Eigen::Lower> {
 public:
  Cholesky() { cholmod().print = 0; }  // "not positive definite" is an answer here
};

Elimination::Elimination(int interior, const Sparse& lower)
    : A_ii_(interior, interior),
      A_bi_(lower.rows() - interior, interior),
      A_bb_(lower.rows() - interior, lower.rows() - interior),
      cholesky_(std::make_unique<Cholesky>()) {
  COVEY_CHECK(lower.rows() == lower.cols() && interior >= 0 && interior <= lower.rows());
  const Eigen::Index boundary = lower.rows() - interior;
  std::vector<Eigen::Triplet<double>> of_ii;
  std::vector<Eigen::Triplet<double>> of_bi;
  std::vector<Eigen::Triplet<double>> of_bb;
  for (int k = 0; k < interior; ++k) of_ii.emplace_back(k, k, 0.0);
  for (int k = 0; k < boundary; ++k) of_bb.emplace_back(k, k, 0.0);
  for (int column = 0; column < lower.outerSize(); ++column) {
    for (Sparse::InnerIterator entry(lower, column); entry; ++entry) {
      const int row = static_cast<int>(entry.row());
      COVEY_CHECK(row >= column);
      if (row < interior) {
        of_ii.emplace_back(row, column, entry.value());
      } else if (column < interior) {
        of_bi.emplace_back(row - interior, column, entry.value());
      } else {
        of_bb.emplace_back(row - interior, column - interior, entry.value());
      }
    }
  }
  A_ii_.setFromTriplets(of_ii.begin(), of_ii.end());
  A_bi_.setFromTriplets(of_bi.begin(), of_bi.end());
  A_bb_.setFromTriplets(of_bb.begin(), of_bb.end());
  if (interior > 0) cholesky_->analyzePattern(A_ii_);
}

Elimination::~Elimination() = default;
Elimination::Elimination(Elimination&&) noexcept = default;

bool Elimination::factorise(const Eigen::VectorXd& D) {
  COVEY_CHECK(D.size() == A_ii_.rows() + A_bb_.rows());
  D_b_ = D.tail(A_bb_.rows());
  if (A_ii_.rows() == 0) return true;
  Sparse shifted = A_ii_;
  for (int k = 0; k < shifted.cols(); ++k) shifted.valuePtr()[shifted.outerIndexPtr()[k]] += D[k];
  cholesky_->factorize(shifted);
  return cholesky_->info() == Eigen::Success;
}

Eigen::MatrixXd Elimination::solve(const Eigen::MatrixXd& B) const {
  if (B.size() == 0) return B;
  return cholesky_->solve(B);
}

Eigen::MatrixXd Elimination::complement() const {
  Eigen::MatrixXd S = Sparse(A_bb_.selfadjointView<Eigen::Lower>());
  S.diagonal() += D_b_;
  if (A_bi_.nonZeros() > 0) S -= A_bi_ * solve(Sparse(A_bi_.transpose()));
  return S;
}

}  // namespace covey::graph
