// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/partial_cholesky.h"

#include <camd.h>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/graph/dense.h"

namespace covey::graph {
namespace {

// Two pivots share a front where at most this part of its columns would be zeros: larger dense kernels are worth some.
constexpr double kZeros = 0.2;

std::vector<std::vector<int>> adjacency(std::size_t variables, const std::vector<std::vector<int>>& cliques) {
  std::vector<std::vector<int>> adjacent(variables);
  for (const auto& clique : cliques) {
    for (const int a : clique) {
      for (const int b : clique) {
        if (a != b) adjacent[a].push_back(b);
      }
    }
  }
  for (auto& list : adjacent) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return adjacent;
}

std::vector<int> inverse(const std::vector<int>& order) {
  std::vector<int> place(order.size());
  for (std::size_t p = 0; p < order.size(); ++p) place[order[p]] = static_cast<int>(p);
  return place;
}

// The later places in the order that the elimination of each place touches (the pattern of L's columns).
std::vector<std::vector<int>> column_structure(const std::vector<std::vector<int>>& adjacent,
                                               const std::vector<int>& order, int eliminated) {
  const std::vector<int> place = inverse(order);
  std::vector<std::vector<int>> structure(eliminated);
  std::vector<std::vector<int>> children(order.size());
  std::vector<int> merged;
  for (int p = 0; p < eliminated; ++p) {
    auto& mine = structure[p];
    for (const int other : adjacent[order[p]]) {
      if (place[other] > p) mine.push_back(place[other]);
    }
    std::sort(mine.begin(), mine.end());
    for (const int child : children[p]) {
      merged.clear();
      std::set_union(mine.begin(), mine.end(), std::next(structure[child].begin()), structure[child].end(),
                     std::back_inserter(merged));
      mine.swap(merged);
    }
    if (!mine.empty()) children[mine.front()].push_back(p);
  }
  return structure;
}

// A front as it is filled: its first columns, and the rest.
struct Target {
  Eigen::MatrixXd& L;
  Eigen::MatrixXd& update;

  template <typename Block>
  void add(int row, int column, const Block& block) {
    const int pivot_rows = static_cast<int>(L.cols());
    if (column < pivot_rows) {
      L.block(row, column, block.rows(), block.cols()) += block;
    } else {
      update.block(row - pivot_rows, column - pivot_rows, block.rows(), block.cols()) += block;
    }
  }
  // At the mirrored place where that one is above the diagonal.
  template <typename Block>
  void add_below_diagonal(int row, int column, const Block& block) {
    if (row >= column) {
      add(row, column, block);
    } else {
      add(column, row, block.transpose());
    }
  }
};

}  // namespace

PartialCholesky::PartialCholesky(const std::vector<int>& sizes, const std::vector<std::vector<int>>& cliques,
                                 const std::vector<bool>& kept)
    : sizes_(sizes) {
  COVEY_CHECK(kept.size() == sizes.size());
  for (std::size_t v = 0; v < sizes.size(); ++v) {
    offsets_.push_back(size_);
    size_ += sizes[v];
    if (kept[v]) kept_size_ += sizes[v];
  }
  const auto adjacent = adjacency(sizes.size(), cliques);
  order_ = order_variables(adjacent, kept);
  int offset = 0;
  for (const int variable : order_) {
    ordered_offsets_.push_back(offset);
    offset += sizes[variable];
  }
  const int eliminated = static_cast<int>(std::count(kept.begin(), kept.end(), false));
  make_fronts(column_structure(adjacent, order_, eliminated), eliminated);

  std::vector<int> front_of(sizes.size(), static_cast<int>(fronts_.size()) - 1);  // by place, of pivots
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    for (int k = 0; k < fronts_[f].pivots; ++k) front_of[fronts_[f].variables[k]] = static_cast<int>(f);
  }
  const std::vector<int> place = inverse(order_);
  for (std::size_t c = 0; c < cliques.size(); ++c) {
    COVEY_CHECK(!cliques[c].empty());
    int first = place[cliques[c].front()];
    for (const int variable : cliques[c]) first = std::min(first, place[variable]);
    Front& front = fronts_[front_of[first]];
    front.cliques.push_back(static_cast<int>(c));
    auto& rows = clique_rows_.emplace_back();
    auto& widths = clique_sizes_.emplace_back();
    for (const int variable : cliques[c]) {
      const auto found = std::lower_bound(front.variables.begin(), front.variables.end(), place[variable]);
      rows.push_back(front.rows[found - front.variables.begin()]);
      widths.push_back(sizes[variable]);
    }
  }
}

std::vector<int> PartialCholesky::order_variables(const std::vector<std::vector<int>>& adjacent,
                                                  const std::vector<bool>& kept) const {
  std::vector<int> order;
  const int n = static_cast<int>(adjacent.size());
  if (n == 0) return order;
  std::vector<int> starts = {0};
  std::vector<int> rows;
  std::vector<int> last(n);
  for (int v = 0; v < n; ++v) {
    rows.insert(rows.end(), adjacent[v].begin(), adjacent[v].end());
    starts.push_back(static_cast<int>(rows.size()));
    last[v] = kept[v] && n > 1 ? 1 : 0;
  }
  double control[CAMD_CONTROL];
  double info[CAMD_INFO];
  camd_defaults(control);
  control[CAMD_DENSE] = -1.0;
  order.resize(n);
  if (rows.empty()) rows.push_back(0);
  const int status = camd_order(n, starts.data(), rows.data(), order.data(), control, info, last.data());
  COVEY_CHECK(status == CAMD_OK);
  std::sort(std::stable_partition(order.begin(), order.end(), [&](int v) { return !kept[v]; }), order.end());
  return order;
}

// Neighbours in the order become one front while the columns of the first are nearly those of the second.
void PartialCholesky::make_fronts(const std::vector<std::vector<int>>& structure, int eliminated) {
  const auto size_at = [&](int p) { return sizes_[order_[p]]; };
  std::vector<int> below(eliminated);  // rows
  for (int p = 0; p < eliminated; ++p) {
    for (const int q : structure[p]) below[p] += size_at(q);
  }
  for (int first = 0; first < eliminated;) {
    int last = first;
    int width = size_at(first);
    double zeros = 0.0;
    while (last + 1 < eliminated && !structure[last].empty() && structure[last].front() == last + 1) {
      const int next_width = width + size_at(last + 1);
      const double next_zeros = zeros + width * (size_at(last + 1) + below[last + 1] - below[last]);
      if (next_zeros > kZeros * next_width * (0.5 * next_width + below[last + 1])) break;
      ++last;
      width = next_width;
      zeros = next_zeros;
    }
    std::vector<int> variables(last - first + 1);
    std::iota(variables.begin(), variables.end(), first);
    const int pivots = static_cast<int>(variables.size());
    variables.insert(variables.end(), structure[last].begin(), structure[last].end());
    add_front(std::move(variables), pivots);
    first = last + 1;
  }
  std::vector<int> kept(order_.size() - eliminated);
  std::iota(kept.begin(), kept.end(), eliminated);
  add_front(std::move(kept), 0);

  std::vector<int> front_of(order_.size(), static_cast<int>(fronts_.size()) - 1);
  for (std::size_t f = 0; f < fronts_.size(); ++f) {
    for (int k = 0; k < fronts_[f].pivots; ++k) front_of[fronts_[f].variables[k]] = static_cast<int>(f);
  }
  for (std::size_t f = 0; f + 1 < fronts_.size(); ++f) {
    Front& front = fronts_[f];
    if (front.pivots == static_cast<int>(front.variables.size())) continue;  // nothing is left of it
    front.parent = front_of[front.variables[front.pivots]];
    Front& parent = fronts_[front.parent];
    parent.children.push_back(static_cast<int>(f));
    for (std::size_t k = front.pivots; k < front.variables.size(); ++k) {
      const auto found =
          std::lower_bound(parent.variables.begin(), parent.variables.end(), front.variables[k]);
      COVEY_CHECK(found != parent.variables.end() && *found == front.variables[k]);
      front.rows_in_parent.push_back(parent.rows[found - parent.variables.begin()]);
    }
  }
}

void PartialCholesky::add_front(std::vector<int> variables, int pivots) {
  Front front;
  front.variables = std::move(variables);
  front.pivots = pivots;
  int rows = 0;
  for (std::size_t k = 0; k < front.variables.size(); ++k) {
    if (static_cast<int>(k) == pivots) front.pivot_rows = rows;
    front.rows.push_back(rows);
    rows += sizes_[order_[front.variables[k]]];
  }
  if (pivots == static_cast<int>(front.variables.size())) front.pivot_rows = rows;
  front.rows.push_back(rows);
  fronts_.push_back(std::move(front));
}

bool PartialCholesky::factorise(const std::vector<Eigen::MatrixXd>& blocks, const Eigen::VectorXd& damping) {
  COVEY_CHECK(blocks.size() == clique_rows_.size() && damping.size() == size_);
  for (Front& front : fronts_) {
    assemble(front, blocks, damping);
    if (front.pivots == 0) continue;
    const Eigen::Index p = front.pivot_rows;
    auto pivots = front.L.topRows(p);
    if (!cholesky_in_place(pivots)) return false;
    auto below = front.L.bottomRows(front.L.rows() - p);
    divide_by_transposed(pivots, below);
    subtract_square(below, front.update);
  }
  return true;
}

void PartialCholesky::assemble(Front& front, const std::vector<Eigen::MatrixXd>& blocks,
                               const Eigen::VectorXd& damping) {
  const int rows = front.rows.back();
  front.L.setZero(rows, front.pivot_rows);
  front.update.setZero(rows - front.pivot_rows, rows - front.pivot_rows);
  Target target{front.L, front.update};
  for (const int c : front.cliques) {
    const auto& at = clique_rows_[c];
    const auto& widths = clique_sizes_[c];
    int column = 0;
    for (std::size_t b = 0; b < at.size(); ++b) {
      int row = column;
      for (std::size_t a = b; a < at.size(); ++a) {
        target.add_below_diagonal(at[a], at[b], blocks[c].block(row, column, widths[a], widths[b]));
        row += widths[a];
      }
      column += widths[b];
    }
  }
  const std::size_t own = front.pivots == 0 ? front.variables.size() : static_cast<std::size_t>(front.pivots);
  Eigen::MatrixXd& diagonal = front.pivots == 0 ? front.update : front.L;
  for (std::size_t k = 0; k < own; ++k) {
    const int variable = order_[front.variables[k]];
    diagonal.block(front.rows[k], front.rows[k], sizes_[variable], sizes_[variable]).diagonal() +=
        damping.segment(offsets_[variable], sizes_[variable]);
  }
  for (const int c : front.children) {
    Front& child = fronts_[c];
    const auto& at = child.rows_in_parent;
    for (std::size_t b = 0; b < at.size(); ++b) {
      const int column = child.rows[child.pivots + b] - child.pivot_rows;
      const int width = child.rows[child.pivots + b + 1] - child.rows[child.pivots + b];
      for (std::size_t a = b; a < at.size(); ++a) {
        const int row = child.rows[child.pivots + a] - child.pivot_rows;
        const int height = child.rows[child.pivots + a + 1] - child.rows[child.pivots + a];
        target.add(at[a], at[b], child.update.block(row, column, height, width));
      }
    }
    child.update.resize(0, 0);
  }
}

Eigen::VectorXd PartialCholesky::forward(const Eigen::VectorXd& b) const {
  COVEY_CHECK(b.size() == size_);
  Eigen::VectorXd x(size_);
  for (std::size_t p = 0; p < order_.size(); ++p) {
    x.segment(ordered_offsets_[p], sizes_[order_[p]]) = b.segment(offsets_[order_[p]], sizes_[order_[p]]);
  }
  Eigen::VectorXd others;
  for (const Front& front : fronts_) {
    if (front.pivots == 0) continue;
    const Eigen::Index p = front.pivot_rows;
    auto mine = x.segment(ordered_offsets_[front.variables.front()], p);
    front.L.topRows(p).triangularView<Eigen::Lower>().solveInPlace(mine);
    others.noalias() = front.L.bottomRows(front.L.rows() - p) * mine;
    for (std::size_t k = front.pivots; k < front.variables.size(); ++k) {
      const int width = front.rows[k + 1] - front.rows[k];
      x.segment(ordered_offsets_[front.variables[k]], width) -= others.segment(front.rows[k] - p, width);
    }
  }
  return x;
}

Eigen::VectorXd PartialCholesky::backward(Eigen::VectorXd x) const {
  COVEY_CHECK(x.size() == size_);
  Eigen::VectorXd others;
  for (auto front = fronts_.rbegin(); front != fronts_.rend(); ++front) {
    if (front->pivots == 0) continue;
    const Eigen::Index p = front->pivot_rows;
    others.resize(front->L.rows() - p);
    for (std::size_t k = front->pivots; k < front->variables.size(); ++k) {
      const int width = front->rows[k + 1] - front->rows[k];
      others.segment(front->rows[k] - p, width) = x.segment(ordered_offsets_[front->variables[k]], width);
    }
    auto mine = x.segment(ordered_offsets_[front->variables.front()], p);
    mine.noalias() -= front->L.bottomRows(front->L.rows() - p).transpose() * others;
    front->L.topRows(p).triangularView<Eigen::Lower>().transpose().solveInPlace(mine);
  }
  Eigen::VectorXd result(size_);
  for (std::size_t p = 0; p < order_.size(); ++p) {
    result.segment(offsets_[order_[p]], sizes_[order_[p]]) =
        x.segment(ordered_offsets_[p], sizes_[order_[p]]);
  }
  return result;
}

}  // namespace covey::graph
