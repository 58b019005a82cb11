// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/separator.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace covey::graph {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kSmallestDiagonal = 1e-6;  // for the damping of variables without weight

std::vector<Key> sorted(std::vector<Key> keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

}  // namespace

Separator::Separator(const Graph& graph, const Values& values, const std::vector<Key>& kept)
    : kept_(sorted(kept)) {
  const std::vector<Key> of_factors = graph.keys();
  std::set_union(of_factors.begin(), of_factors.end(), kept_.begin(), kept_.end(), std::back_inserter(keys_));
  keys_.erase(std::remove_if(keys_.begin(), keys_.end(), [&](Key key) { return graph.is_constant(key); }),
              keys_.end());
  std::vector<int> sizes;
  std::vector<bool> is_kept;
  std::map<Key, int> variable;
  offsets_.push_back(0);
  for (const Key key : keys_) {
    variable[key] = static_cast<int>(sizes.size());
    sizes.push_back(values.type(key).tangent);
    offsets_.push_back(offsets_.back() + sizes.back());
    is_kept.push_back(std::binary_search(kept_.begin(), kept_.end(), key));
  }
  COVEY_CHECK(std::count(is_kept.begin(), is_kept.end(), true) == static_cast<std::ptrdiff_t>(kept_.size()));
  std::vector<std::vector<int>> cliques;
  for (const FactorId id : graph.ids()) {
    place_[id] = parts_.size();
    Part& part = parts_.emplace_back();
    part.factor = graph.shared_factor(id);
    part.robust = graph.robust(id);
    std::vector<int> clique;
    for (const Key key : part.factor->keys()) {
      const auto found = variable.find(key);
      part.variables.push_back(found == variable.end() ? -1 : found->second);
      if (found != variable.end()) clique.push_back(found->second);
    }
    if (clique.empty()) continue;
    part.block = static_cast<int>(cliques.size());
    cliques.push_back(std::move(clique));
  }
  blocks_.resize(cliques.size());
  cholesky_ = std::make_unique<PartialCholesky>(sizes, cliques, is_kept);
}

double Separator::cost(const Values& values) const {
  double sum = 0.0;
  for (const Part& part : parts_) {
    if (part.weight > 0.0) sum += part.weight * part.robust.cost(squared_residual(*part.factor, values));
  }
  return sum;
}

double Separator::linearise(const Part& part, const Values& values) {
  const Factor& factor = *part.factor;
  const int rows = factor.residual_dim();
  int columns = 0;
  std::size_t doubles = 0;
  for (std::size_t k = 0; k < part.variables.size(); ++k) {
    doubles += static_cast<std::size_t>(rows) * factor.types()[k].tangent;
    if (part.variables[k] >= 0) columns += factor.types()[k].tangent;
  }
  memory_.resize(doubles);
  r_.resize(rows);
  J_.resize(rows, columns);
  std::vector<double*> jacobians;
  for (double* free = memory_.data(); const VariableType type : factor.types()) {
    jacobians.push_back(free);
    free += rows * type.tangent;
  }
  factor.evaluate(variable_pointers(factor, values).data(), r_.data(), jacobians.data());
  const double squared = r_.squaredNorm();
  const double scale = std::sqrt(part.weight * part.robust.derivative(squared));
  r_ *= scale;
  int column = 0;
  for (std::size_t k = 0; k < part.variables.size(); ++k) {
    if (part.variables[k] < 0) continue;
    const int tangent = factor.types()[k].tangent;
    J_.middleCols(column, tangent) = scale * Eigen::Map<const RowMajor>(jacobians[k], rows, tangent);
    column += tangent;
  }
  return part.weight * part.robust.cost(squared);
}

bool Separator::factorise(const Values& values, double damping) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(offsets_.back());
  for (const Part& part : parts_) {
    if (part.block < 0) continue;
    Eigen::MatrixXd& H = blocks_[part.block];
    linearise(part, values);
    H.noalias() = J_.transpose().lazyProduct(J_);
    int column = 0;
    for (const int variable : part.variables) {
      if (variable < 0) continue;
      const int tangent = offsets_[variable + 1] - offsets_[variable];
      diagonal.segment(offsets_[variable], tangent) += H.diagonal().segment(column, tangent);
      column += tangent;
    }
  }
  return cholesky_->factorise(blocks_, damping * diagonal.cwiseMax(kSmallestDiagonal));
}

Separator::Reduction Separator::reduce(const Values& values) {
  Reduction reduction;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(offsets_.back());
  for (const Part& part : parts_) {
    if (part.weight == 0.0) continue;
    reduction.cost += linearise(part, values);
    int column = 0;
    for (const int variable : part.variables) {
      if (variable < 0) continue;
      const int tangent = offsets_[variable + 1] - offsets_[variable];
      b.segment(offsets_[variable], tangent).noalias() -= J_.middleCols(column, tangent).transpose() * r_;
      column += tangent;
    }
  }
  forward_ = cholesky_->forward(b);
  reduction.b = forward_.tail(cholesky_->kept_size());
  reduction.gain = forward_.head(cholesky_->size() - cholesky_->kept_size()).squaredNorm();
  return reduction;
}

void Separator::move(const Eigen::VectorXd& kept_step, Values& values) const {
  COVEY_CHECK(kept_step.size() == cholesky_->kept_size() && forward_.size() == cholesky_->size());
  Eigen::VectorXd x = forward_;
  x.tail(kept_step.size()) = kept_step;
  const Eigen::VectorXd step = cholesky_->backward(std::move(x));
  for (std::size_t v = 0; v < keys_.size(); ++v) {
    values.perturb(keys_[v], step.segment(offsets_[v], offsets_[v + 1] - offsets_[v]));
  }
}

}  // namespace covey::graph
