// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A graph and its values as sparse normal equations, laid out once and solved as often as wanted by Levenberg-Marquardt:
//
//   (J^T W J + diag(damping)) d = -J^T W r,   x <- x * Exp(d)
//
// with W the weights that are set here times rho' of the kernels. Factors of weight 0 leave the pattern with the next
// factorisation, so that they do not fill it. For core/graph's own sources.

#include <optional>
#include <vector>

#include "core/graph/damped_system.h"
#include "core/graph/solve.h"

namespace covey::graph {

class SparseProblem {
 public:
  // Both must outlive the problem; solve() writes into the values.
  SparseProblem(const Graph& graph, Values& values);

  // Scales a factor's squared residual, 1 at first.
  void set_weight(FactorId id, double weight) { terms_[id].weight = weight; }
  // Unweighted, before any kernel, at the present values.
  double squared_residual(FactorId id);

  SolveResult solve(const SolveOptions& options);

 private:
  static constexpr int kConstant = -1;

  struct Variable {
    double* home = nullptr;
    VariableType type;
    int block = kConstant;  // in the normal equations
  };
  struct Term {
    const Factor* factor = nullptr;  // null where the graph has none
    Robust robust;
    double weight = 1.0;
    std::vector<int> variables;
    bool in_pattern = false;
    // Where in the matrix a product of two of its Jacobians goes; row and column count the variables above.
    struct Product {
      int row = 0;
      int column = 0;
      Eigen::Index first = 0;
      Eigen::Index stride = 0;
    };
    std::vector<Product> products;
  };
  using State = std::vector<double>;  // kMaxAmbient doubles for each variable

  struct Step {
    State to;
    double cost = 0.0;
    double promised = 0.0;  // what the linear model says that the cost falls by
    bool is_rounding = false;
  };

  // Whether it has all factors with a weight; and, where a new factorisation is due anyway, no others.
  bool pattern_fits() const;
  void lay_out();
  State state() const;
  void store(const State& x);

  // rho of the weighted residual; the residual and, if wanted, its Jacobians in r_ and jacobians_, then scaled by
  // sqrt(weight rho').
  double evaluate(const Term& term, const State& x, bool with_jacobians);
  double cost(const State& x);
  void linearise(const State& x);  // into the matrix of system_ and gradient_
  // Nothing where the model has no minimum that is lower.
  std::optional<Step> step_from(const State& x, double radius);

  std::vector<Variable> variables_;  // in the order of their keys
  std::vector<Term> terms_;          // by FactorId
  std::optional<DampedSystem> system_;
  Eigen::VectorXd gradient_;  // of half the cost

  // Of one term at a time.
  std::vector<const double*> x_;
  std::vector<double> r_;
  std::vector<double> J_;
  std::vector<double*> jacobians_;
};

}  // namespace covey::graph
