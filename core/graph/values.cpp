// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/values.h"

namespace covey::graph {

std::vector<Key> Values::keys() const {
  std::vector<Key> keys;
  keys.reserve(variables_.size());
  for (const auto& [key, variable] : variables_) keys.push_back(key);
  return keys;
}

void Values::perturb(Key key, const Eigen::VectorXd& delta) {
  COVEY_CHECK(delta.size() == type(key).tangent);
  plus(type(key), data(key), delta.data(), data(key));
}

const Values::Variable& Values::at(Key key) const {
  const auto found = variables_.find(key);
  COVEY_CHECK(found != variables_.end());
  return found->second;
}

}  // namespace covey::graph
