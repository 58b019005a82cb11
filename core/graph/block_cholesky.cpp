// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/block_cholesky.h"

#include <cholmod.h>

#include <Eigen/SparseCore>
#include <algorithm>

#include "core/base/error.h"
#include "core/graph/one_thread.h"

namespace covey::graph {
namespace {

// The lower triangle of a square matrix in compressed columns, as CHOLMOD sees memory that is ours.
cholmod_sparse lower_triangle(std::vector<int>& outer, std::vector<int>& inner, double* values) {
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = outer.size() - 1;
  matrix.nzmax = inner.size();
  matrix.p = outer.data();
  matrix.i = inner.data();
  matrix.x = values;
  matrix.stype = -1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = 1;
  matrix.packed = 1;
  return matrix;
}

class Common {
 public:
  Common() {
    cholmod_start(&common_);
    common_.print = 0;
  }
  ~Common() { cholmod_finish(&common_); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  cholmod_common* operator->() { return &common_; }
  cholmod_common* get() { return &common_; }

 private:
  cholmod_common common_{};
};

// Variables in an order of elimination with little fill.
std::vector<int> elimination_order(int variables, const std::vector<std::pair<int, int>>& pairs) {
  std::vector<int> outer(variables + 1, 0);
  std::vector<int> inner;
  for (const auto& [column, row] : pairs) {
    ++outer[column + 1];
    inner.push_back(row);
  }
  for (int v = 0; v < variables; ++v) outer[v + 1] += outer[v];
  cholmod_sparse pattern = lower_triangle(outer, inner, nullptr);
  Common common;
  common->supernodal = CHOLMOD_SIMPLICIAL;
  cholmod_factor* factor = cholmod_analyze(&pattern, common.get());
  COVEY_CHECK(factor != nullptr);
  const int* order = static_cast<const int*>(factor->Perm);
  std::vector<int> variable(order, order + variables);
  cholmod_free_factor(&factor, common.get());
  return variable;
}

// Each pair once, the smaller first, in order.
std::vector<std::pair<int, int>> unique_pairs(const std::vector<std::pair<int, int>>& pairs) {
  std::vector<std::pair<int, int>> unique;
  unique.reserve(pairs.size());
  for (const auto& [i, j] : pairs) {
    if (i != j) unique.emplace_back(std::min(i, j), std::max(i, j));
  }
  std::sort(unique.begin(), unique.end());
  unique.erase(std::unique(unique.begin(), unique.end()), unique.end());
  return unique;
}

}  // namespace

struct BlockCholesky::Cholmod {
  Common common;
  cholmod_factor* factor = nullptr;
  double solves_per_factorisation = 0.0;
  // Of a solve, kept for the next one.
  cholmod_dense* X = nullptr;
  cholmod_dense* Y = nullptr;
  cholmod_dense* E = nullptr;

  ~Cholmod() {
    cholmod_free_factor(&factor, common.get());
    for (cholmod_dense** dense : {&X, &Y, &E}) cholmod_free_dense(dense, common.get());
  }
};

BlockCholesky::BlockCholesky(const std::vector<int>& sizes, const std::vector<std::pair<int, int>>& pairs)
    : position_(sizes.size()), below_(sizes.size()), cholmod_(std::make_unique<Cholmod>()) {
  const int variables = static_cast<int>(sizes.size());
  if (variables == 0) return;
  const auto unique = unique_pairs(pairs);
  variable_ = elimination_order(variables, unique);
  start_ = {0};
  for (int p = 0; p < variables; ++p) {
    position_[variable_[p]] = p;
    start_.push_back(start_.back() + sizes[variable_[p]]);
  }
  rows_ = start_.back();
  for (const auto& [i, j] : unique) {
    const auto& [column, row] = std::minmax(position_[i], position_[j]);
    below_[column].push_back(row);
  }
  outer_ = {0};
  for (int p = 0; p < variables; ++p) {
    std::sort(below_[p].begin(), below_[p].end());
    first_value_.push_back(static_cast<Eigen::Index>(inner_.size()));
    for (int column = start_[p]; column < start_[p + 1]; ++column) {
      for (int row = start_[p]; row < start_[p + 1]; ++row) inner_.push_back(row);
      for (const int q : below_[p]) {
        for (int row = start_[q]; row < start_[q + 1]; ++row) inner_.push_back(row);
      }
      outer_.push_back(static_cast<int>(inner_.size()));
    }
  }
  values_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(inner_.size()));

  Common& common = cholmod_->common;
  common->nmethods = 1;
  common->method[0].ordering = CHOLMOD_NATURAL;
  common->postorder = 0;  // the blocks' order is a postorder already
  common->final_ll = 1;   // L L^T: L D L^T would pass what is not positive definite
  cholmod_sparse matrix = lower_triangle(outer_, inner_, values_.data());
  cholmod_->factor = cholmod_analyze(&matrix, common.get());
  COVEY_CHECK(cholmod_->factor != nullptr);
  cholmod_->solves_per_factorisation = common->fl / (4.0 * common->lnz);
}

BlockCholesky::~BlockCholesky() = default;
BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;

void BlockCholesky::set_zero() { values_.setZero(); }

BlockCholesky::Place BlockCholesky::place(int i, int j) const {
  const auto [column, row] = std::minmax(position_[i], position_[j]);
  Place place{variable_[row], variable_[column], first_value_[column],
              outer_[start_[column] + 1] - outer_[start_[column]]};
  if (row == column) return place;
  place.first += start_[column + 1] - start_[column];
  const auto found = std::lower_bound(below_[column].begin(), below_[column].end(), row);
  COVEY_CHECK(found != below_[column].end() && *found == row);
  for (auto q = below_[column].begin(); q != found; ++q) place.first += start_[*q + 1] - start_[*q];
  return place;
}

void BlockCholesky::add(int i, int j, const Eigen::Ref<const Eigen::MatrixXd>& block) {
  const Place at = place(i, j);
  const bool as_given = at.row_variable == i;
  Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> stored(
      values_.data() + at.first, as_given ? block.rows() : block.cols(),
      as_given ? block.cols() : block.rows(), Eigen::OuterStride<>(at.stride));
  if (as_given) {
    stored += block;
  } else {
    stored += block.transpose();
  }
}

Eigen::VectorXd BlockCholesky::diagonal() const {
  Eigen::VectorXd diagonal(rows_);
  for (std::size_t p = 0; p < variable_.size(); ++p) {
    for (int column = start_[p]; column < start_[p + 1]; ++column)
      diagonal(column) = values_(outer_[column] + column - start_[p]);
  }
  return diagonal;
}

Eigen::VectorXd BlockCholesky::times(const Eigen::VectorXd& x) const {
  if (rows_ == 0) return x;
  const Eigen::Map<const Eigen::SparseMatrix<double>> lower(rows_, rows_, values_.size(), outer_.data(),
                                                            inner_.data(), values_.data());
  return lower.selfadjointView<Eigen::Lower>() * x;
}

bool BlockCholesky::factorise(const Eigen::VectorXd& damping) {
  if (rows_ == 0) return true;
  const Eigen::VectorXd undamped = diagonal();
  const auto set_diagonal = [&](const Eigen::VectorXd& entries) {
    for (std::size_t p = 0; p < variable_.size(); ++p) {
      for (int column = start_[p]; column < start_[p + 1]; ++column)
        values_(outer_[column] + column - start_[p]) = entries(column);
    }
  };
  if (damping.size() > 0) set_diagonal(undamped + damping);
  cholmod_sparse matrix = lower_triangle(outer_, inner_, values_.data());
  const OneThread one_thread;
  cholmod_factorize(&matrix, cholmod_->factor, cholmod_->common.get());
  if (damping.size() > 0) set_diagonal(undamped);
  return cholmod_->common->status == CHOLMOD_OK;
}

Eigen::MatrixXd BlockCholesky::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  if (rows_ == 0) return B;
  cholmod_dense b{};
  b.nrow = static_cast<std::size_t>(B.rows());
  b.ncol = static_cast<std::size_t>(B.cols());
  b.d = static_cast<std::size_t>(B.outerStride());
  b.nzmax = b.d * b.ncol;
  b.x = const_cast<double*>(B.data());
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  Cholmod& c = *cholmod_;
  const OneThread one_thread;
  COVEY_CHECK(cholmod_solve2(CHOLMOD_A, c.factor, &b, nullptr, &c.X, nullptr, &c.Y, &c.E, c.common.get()));
  return Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(c.X->x), B.rows(), B.cols());
}

double BlockCholesky::solves_per_factorisation() const { return cholmod_->solves_per_factorisation; }

}  // namespace covey::graph
