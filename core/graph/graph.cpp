// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/graph.h"

#include <algorithm>

namespace covey::graph {

FactorId Graph::add(std::shared_ptr<const Factor> factor, Robust robust) {
  COVEY_CHECK(factor != nullptr);
  if (free_.empty()) {
    entries_.push_back({std::move(factor), robust});
    return entries_.size() - 1;
  }
  const FactorId id = free_.back();
  free_.pop_back();
  entries_[id] = {std::move(factor), robust};
  return id;
}

void Graph::remove(FactorId id) {
  COVEY_CHECK(has(id));
  entries_[id] = {};
  free_.push_back(id);
}

std::vector<FactorId> Graph::ids() const {
  std::vector<FactorId> ids;
  ids.reserve(size());
  for (FactorId id = 0; id < entries_.size(); ++id) {
    if (has(id)) ids.push_back(id);
  }
  return ids;
}

std::vector<FactorId> Graph::ids_touching(const std::vector<Key>& keys) const {
  const std::set<Key> wanted(keys.begin(), keys.end());
  std::vector<FactorId> touching;
  for (const FactorId id : ids()) {
    const auto& of_factor = factor(id).keys();
    const bool touches =
        std::any_of(of_factor.begin(), of_factor.end(), [&](Key key) { return wanted.contains(key); });
    if (touches) touching.push_back(id);
  }
  return touching;
}

std::vector<Key> Graph::keys() const {
  std::vector<Key> keys;
  for (const FactorId id : ids()) keys.insert(keys.end(), factor(id).keys().begin(), factor(id).keys().end());
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

void Graph::set_constant(Key key, bool constant) {
  if (constant) {
    constant_.insert(key);
  } else {
    constant_.erase(key);
  }
}

void Graph::hold(Key key, const Values& values) {
  if (!held_.has(key)) held_.copy(key, values);
}

std::vector<const double*> variable_pointers(const Factor& factor, const Values& values) {
  std::vector<const double*> x;
  x.reserve(factor.keys().size());
  for (std::size_t k = 0; k < factor.keys().size(); ++k) {
    COVEY_CHECK(values.type(factor.keys()[k]) == factor.types()[k]);
    x.push_back(values.data(factor.keys()[k]));
  }
  return x;
}

double squared_residual(const Factor& factor, const Values& values) {
  Eigen::VectorXd residual(factor.residual_dim());
  factor.evaluate(variable_pointers(factor, values).data(), residual.data(), nullptr);
  return residual.squaredNorm();
}

double cost(const Graph& graph, const Values& values) {
  double sum = 0.0;
  for (const FactorId id : graph.ids())
    sum += graph.robust(id).cost(squared_residual(graph.factor(id), values));
  return sum;
}

}  // namespace covey::graph
