// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The values of a graph's variables by key, each of a type of manifold.h:
//
//   Values values;
//   values.set({'x', 0}, SE3{});
//   const SE3 T = values.get<SE3>({'x', 0});
//
// A variable's doubles stay where they are until it is erased. Asking for a missing key or with another type
// is a mistake of the caller (COVEY_CHECK).

#include <array>
#include <map>
#include <vector>

#include "core/base/error.h"
#include "core/graph/key.h"
#include "core/graph/manifold.h"

namespace covey::graph {

class Values {
 public:
  template <typename T>
  void set(Key key, const T& value) {
    Variable& variable = variables_.try_emplace(key, Variable{Manifold<T>::kType, {}}).first->second;
    COVEY_CHECK(variable.type == Manifold<T>::kType);
    Manifold<T>::store(value, variable.x.data());
  }
  template <typename T>
  T get(Key key) const {
    COVEY_CHECK(type(key) == Manifold<T>::kType);
    return Manifold<T>::load(data(key));
  }

  // As it is in `other`.
  void copy(Key key, const Values& other) { variables_[key] = other.at(key); }

  bool has(Key key) const { return variables_.contains(key); }
  void erase(Key key) { variables_.erase(key); }
  std::size_t size() const { return variables_.size(); }
  std::vector<Key> keys() const;  // in order

  VariableType type(Key key) const { return at(key).type; }
  const double* data(Key key) const { return at(key).x.data(); }
  double* data(Key key) { return const_cast<double*>(at(key).x.data()); }

  // x <- x * Exp(delta), delta of the variable's tangent dimension.
  void perturb(Key key, const Eigen::VectorXd& delta);

 private:
  struct Variable {
    VariableType type;
    std::array<double, kMaxAmbient> x;
  };
  const Variable& at(Key key) const;

  std::map<Key, Variable> variables_;
};

}  // namespace covey::graph
