// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A factor graph: factors between variables that are named by keys. The values live apart (values.h), so that
// one graph can be evaluated and solved from many starts. Copies are cheap: they share the factors.
//
//   Graph graph;
//   graph.add(ChordalBetween3{T_i_j, kappa, tau}, {{'x', 0}, {'x', 1}});
//   graph.set_constant({'x', 0});
//   const SolveResult result = solve(graph, values);     // solve.h; also gnc.h, marginal.h, linearise.h
//
// Costs have no factor 1/2: cost = sum over factors of rho(|whitened residual|^2).

#include <array>
#include <memory>
#include <set>
#include <vector>

#include "core/graph/factor.h"
#include "core/graph/robust.h"
#include "core/graph/values.h"

namespace covey::graph {

using FactorId = std::size_t;

class Graph {
 public:
  // The id stays the factor's until it is removed; ids of removed factors are used again.
  template <FactorModel Model>
  FactorId add(const Model& model, const Key (&keys)[Model::Variables::kCount],
               const Noise<Model::kDim>& noise = {}, Robust robust = {}) {
    using Stored = internal::ModelFactor<Model, typename Model::Variables>;
    return add(std::make_shared<Stored>(model, std::to_array(keys), noise), robust);
  }
  FactorId add(std::shared_ptr<const Factor> factor, Robust robust = {});
  void remove(FactorId id);

  bool has(FactorId id) const { return id < entries_.size() && entries_[id].factor != nullptr; }
  const Factor& factor(FactorId id) const { return *entries_[id].factor; }
  const std::shared_ptr<const Factor>& shared_factor(FactorId id) const { return entries_[id].factor; }
  Robust robust(FactorId id) const { return entries_[id].robust; }
  std::size_t size() const { return entries_.size() - free_.size(); }
  std::vector<FactorId> ids() const;  // increasing
  std::vector<FactorId> ids_touching(
      const std::vector<Key>& keys) const;  // factors with at least one of the keys
  std::vector<Key> keys() const;            // of all factors, in order

  // A constant variable is read by its factors and not moved by solvers.
  void set_constant(Key key, bool constant = true);
  bool is_constant(Key key) const { return constant_.contains(key); }

  // A held variable moves like any other, but all Jacobians are taken with it where it was held, as of |r(x) + J_0 d|^2 with d = minus(x, x_0)
  // (linearisation_point.h). For what a linear prior touches, whose own Jacobians cannot follow: were those of the other factors taken elsewhere, the
  // sum would know directions that no factor knows. First-estimates Jacobians: Huang, Mourikis, Roumeliotis, "Observability-based rules for designing
  // consistent EKF SLAM estimators", IJRR 2010.
  // Solves honour it that eliminate some variables first (SolveOptions::eliminate_first); others COVEY_CHECK that none is held.
  void hold(Key key, const Values& values);  // once held, it stays there until it is released
  void release(Key key) { held_.erase(key); }
  const Values& held() const { return held_; }

 private:
  struct Entry {
    std::shared_ptr<const Factor> factor;
    Robust robust;
  };
  std::vector<Entry> entries_;
  std::vector<FactorId> free_;
  std::set<Key> constant_;
  Values held_;
};

// Where a factor's variables stand in memory, for Factor::evaluate. COVEY_CHECKs that they exist with the
// right type.
std::vector<const double*> variable_pointers(const Factor& factor, const Values& values);

// |whitened residual|^2 of one factor, before any robust kernel.
double squared_residual(const Factor& factor, const Values& values);

double cost(const Graph& graph, const Values& values);

}  // namespace covey::graph
