// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What one part of a graph says about the variables that it shares with the rest. The part's first-order model at given values,
// r(x Exp(d)) = r + J d, has the normal equations (H + D) d = b with H = J^T J, b = -J^T r and a diagonal damping
// D = damping diag(H); with its own variables e eliminated (partial_cholesky.h) there remains on the kept ones k
//
//   S d_k = b_k - H_ke H_ee^-1 b_e,     S = H_kk - H_ke H_ee^-1 H_ek
//
// Reduced systems of all parts are added, solved for the kept variables, and each part finds its own by back-substitution: one
// step of Levenberg-Marquardt on the whole graph. Factors may be weighted, and weights may change between two steps; the pattern
// is analysed once. A factor of another linearisation may be kept: then the step is that of a simplified Newton method, whose
// right-hand side is exact.

#include <Eigen/Core>
#include <map>
#include <memory>
#include <vector>

#include "core/graph/graph.h"
#include "core/graph/partial_cholesky.h"

namespace covey::graph {

class Separator {
 public:
  // Reads the types of the variables from the values. Kept ones that no factor touches are part of the system, the graph's
  // constant variables are not.
  Separator(const Graph& graph, const Values& values, const std::vector<Key>& kept);

  const std::vector<Key>& kept() const { return kept_; }  // ascending

  // Of the factor's squared residual, 1 at first.
  void set_weight(FactorId id, double weight) { parts_[place_.at(id)].weight = weight; }
  double weight(FactorId id) const { return parts_[place_.at(id)].weight; }
  double cost(const Values& values) const;  // weighted

  // Linearises and factorises. False where H_ee + D is not positive definite: more damping is needed.
  bool factorise(const Values& values, double damping);
  // The lower triangle of S, in the order of kept(); damped like the rest, so that it is positive definite but for rounding.
  const Eigen::MatrixXd& schur() const { return cholesky_->schur(); }

  // The right-hand side at these values, with the factor that is there.
  struct Reduction {
    double cost = 0.0;  // weighted
    double gain = 0.0;  // b_e^T H_ee^-1 b_e: what the model promises of moving the eliminated variables alone
    Eigen::VectorXd b;  // of the kept ones
  };
  Reduction reduce(const Values& values);

  // Moves all variables, given the step of the kept ones that solves the reduced system of the last reduce().
  void move(const Eigen::VectorXd& kept_step, Values& values) const;

 private:
  struct Part {
    std::shared_ptr<const Factor> factor;
    Robust robust;
    double weight = 1.0;
    std::vector<int> variables;  // of the factor, in the order of its keys; -1 for constant ones
    int block = -1;              // none where all are constant
  };
  // One factor's J and r, scaled by the roots of its weight and of the derivative of its kernel; constant variables have no
  // columns. Returns its cost.
  double linearise(const Part& part, const Values& values);

  std::vector<Key> kept_;
  std::vector<Key> keys_;     // of all variables, ascending
  std::vector<int> offsets_;  // of them, and the number of scalars
  std::vector<Part> parts_;
  std::map<FactorId, std::size_t> place_;
  std::unique_ptr<PartialCholesky> cholesky_;
  std::vector<Eigen::MatrixXd> blocks_;
  Eigen::VectorXd forward_;  // of the last reduce()
  std::vector<double> memory_;
  Eigen::MatrixXd J_;
  Eigen::VectorXd r_;
};

}  // namespace covey::graph
