// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/block_cholesky.h"

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

// When each block row is eliminated.
std::vector<int> amd_places(int n, const std::vector<std::pair<int, int>>& pairs) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (const auto& [i, j] : pairs) {
    triplets.emplace_back(i, j, 1.0);
    triplets.emplace_back(j, i, 1.0);
  }
  for (int i = 0; i < n; ++i) triplets.emplace_back(i, i, 1.0);
  Eigen::SparseMatrix<double> pattern(n, n);
  pattern.setFromTriplets(triplets.begin(), triplets.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  std::vector<int> places(n);
  for (int k = 0; k < n; ++k) places[order.indices()[k]] = k;
  return places;
}

}  // namespace

template <int B>
BlockCholesky<B>::BlockCholesky(int n, const std::vector<std::pair<int, int>>& pairs)
    : n_(n), place_(amd_places(n, pairs)), starts_(1, 0) {
  std::vector<std::vector<int>> below(n);
  for (const auto& [i, j] : pairs) {
    COVEY_CHECK(i != j);
    below[std::min(place_[i], place_[j])].push_back(std::max(place_[i], place_[j]));
  }
  // A column's pattern is that of A and of the columns whose first block below the diagonal stands in its row.
  std::vector<std::vector<int>> children(n);
  for (int column = 0; column < n; ++column) {
    std::vector<int>& rows = below[column];
    for (const int child : children[column]) {
      rows.insert(rows.end(), rows_.begin() + starts_[child] + 1, rows_.begin() + starts_[child + 1]);
    }
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    if (!rows.empty()) children[rows.front()].push_back(column);
    rows_.insert(rows_.end(), rows.begin(), rows.end());
    starts_.push_back(static_cast<int>(rows_.size()));
  }
  for (const auto& [i, j] : pairs) {
    const int column = std::min(place_[i], place_[j]);
    const auto row = std::lower_bound(rows_.begin() + starts_[column], rows_.begin() + starts_[column + 1],
                                      std::max(place_[i], place_[j]));
    slots_.emplace_back(static_cast<int>(row - rows_.begin()), place_[i] < place_[j]);
  }
  below_.resize(rows_.size());
  inverse_diagonal_.resize(n);
}

template <int B>
bool BlockCholesky<B>::factorise(const std::vector<Block>& diagonal, const std::vector<Block>& off_diagonal) {
  COVEY_CHECK(static_cast<int>(diagonal.size()) == n_ && off_diagonal.size() == slots_.size());
  for (Block& block : below_) block.setZero();
  for (std::size_t e = 0; e < slots_.size(); ++e) {
    const auto& [slot, transposed] = slots_[e];
    if (transposed) {
      below_[slot] += off_diagonal[e].transpose();
    } else {
      below_[slot] += off_diagonal[e];
    }
  }
  std::vector<Block> pivots(n_);
  for (int i = 0; i < n_; ++i) pivots[place_[i]] = diagonal[i];

  std::vector<int> next(n_);  // of each finished column: the first block that no column has used yet
  std::vector<std::vector<int>> waiting(
      n_);                       // for each column: finished ones whose next block stands in its row
  std::vector<int> slot_of(n_);  // of a row in the current column
  const auto wait = [&](int column) {
    if (next[column] < starts_[column + 1]) waiting[rows_[next[column]]].push_back(column);
  };
  for (int column = 0; column < n_; ++column) {
    for (int slot = starts_[column]; slot < starts_[column + 1]; ++slot) slot_of[rows_[slot]] = slot;
    for (const int done : waiting[column]) {
      const int first = next[done]++;
      const Block L = below_[first];
      pivots[column].noalias() -= L.lazyProduct(L.transpose());
      for (int slot = first + 1; slot < starts_[done + 1]; ++slot) {
        below_[slot_of[rows_[slot]]].noalias() -= below_[slot].lazyProduct(L.transpose());
      }
      wait(done);
    }
    const Eigen::LLT<Block> pivot(pivots[column]);
    if (pivot.info() != Eigen::Success) return false;
    Block& inverse = inverse_diagonal_[column];
    inverse.setIdentity();
    pivot.matrixL().solveInPlace(inverse);
    for (int slot = starts_[column]; slot < starts_[column + 1]; ++slot) {
      const Block block = below_[slot];
      below_[slot].noalias() = block.lazyProduct(inverse.transpose());
    }
    next[column] = starts_[column];
    wait(column);
  }
  return true;
}

template <int B>
void BlockCholesky<B>::solve(Eigen::MatrixXd& x) const {
  using Vector = Eigen::Matrix<double, B, 1>;
  COVEY_CHECK(x.rows() == static_cast<Eigen::Index>(n_) * B);
  std::vector<Vector> y(n_);
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    auto column_of_x = x.col(c);
    for (int i = 0; i < n_; ++i) y[place_[i]] = column_of_x.template segment<B>(B * i);
    for (int column = 0; column < n_; ++column) {
      const Vector known = inverse_diagonal_[column].lazyProduct(y[column]);
      y[column] = known;
      for (int slot = starts_[column]; slot < starts_[column + 1]; ++slot) {
        y[rows_[slot]].noalias() -= below_[slot].lazyProduct(known);
      }
    }
    for (int column = n_ - 1; column >= 0; --column) {
      Vector rest = y[column];
      for (int slot = starts_[column]; slot < starts_[column + 1]; ++slot) {
        rest.noalias() -= below_[slot].transpose().lazyProduct(y[rows_[slot]]);
      }
      y[column].noalias() = inverse_diagonal_[column].transpose().lazyProduct(rest);
    }
    for (int i = 0; i < n_; ++i) column_of_x.template segment<B>(B * i) = y[place_[i]];
  }
}

template class BlockCholesky<4>;
template class BlockCholesky<6>;

}  // namespace covey::pgo
