// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Taking variables out of a graph without losing what was learnt through them, and covariances.
//
// With H = J^T J and b = J^T r of the factors that touch the removed variables m, and k the variables these
// factors share with the rest, the Schur complement
//
//   H_p = H_kk - H_km H_mm^-1 H_mk,   b_p = b_k - H_km H_mm^-1 b_m
//
// is the information that remains on k. It becomes one factor |A d + c|^2, A^T A = H_p, A^T c = b_p, with
// d = minus(x, x_0) from the values at which it was made. A and c stay fixed: a solve afterwards does not
// re-linearise what was removed. Where the prior's variables are then held (Graph::hold), x_0 stays when the next prior
// takes this one's place: all that is known of a variable is linearised at one point, so that what cannot be
// observed (position and yaw of odometry) stays unknown. Directions of m that the factors do not determine are dropped
// (pseudo-inverse). The prior also keeps how uncertain c is, which is not I where errors of factors hang together (SharedError), and passes it on to
// the next one. Source: Sibley, Matthies, Sukhatme, "Sliding window filter with application to planetary
// landing", JFR 2010.

#include <Eigen/Cholesky>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/graph/graph.h"
#include "core/graph/reduced.h"

namespace covey::graph {

class LinearPrior final : public Factor {
 public:
  // A: rows x sum of tangent dimensions, columns in the order of keys; c: rows. The values give the point
  // x_0.
  // spread: the covariance of c.
  LinearPrior(const std::vector<Key>& keys, const Values& values, Eigen::MatrixXd A, Eigen::VectorXd c,
              Eigen::MatrixXd spread);

  void evaluate(const double* const* x, double* residual, double* const* jacobians) const override;

  const Eigen::MatrixXd* spread() const override { return &spread_; }

  const Eigen::MatrixXd& jacobian() const { return A_; }  // A
  const Eigen::VectorXd& offset() const { return c_; }    // c

 private:
  Eigen::MatrixXd A_;
  Eigen::VectorXd c_;
  Eigen::MatrixXd spread_;
  std::vector<std::array<double, kMaxAmbient>> x0_;
};

// The prior that replaces every factor that touches `removed`; null when these share no variable with the
// rest. The graph is not changed. Constant variables are conditioned on: they are not part of the prior and
// may not be removed. Where many of the removed variables are small and share no factors with each other, they
// go first, one by one, if their kind (Key::kind) is given: the same prior in less time.
std::shared_ptr<const LinearPrior> marginalise(const Graph& graph, const Values& values,
                                               const std::vector<Key>& removed, char eliminate_first = 0,
                                               const SharedError& shared = {});

// Does it: removes these factors and variables and adds the prior. Returns the prior's id, or nothing if
// there is none.
std::optional<FactorId> marginalise_out(Graph& graph, Values& values, const std::vector<Key>& removed,
                                        char eliminate_first = 0, const SharedError& shared = {});

// The joint covariance of some variables, in their tangent spaces at the values, in the order asked for (each
// once). All other variables are marginalised, constant ones are certain and may not be asked for. Nothing if
// the graph does not determine its variables (no gauge).
std::optional<Eigen::MatrixXd> marginal_covariance(const Graph& graph, const Values& values,
                                                   const std::vector<Key>& keys);

// The same for graphs as in reduced.h, and for several questions at one cost: variables of one kind are eliminated
// first, and what is left is factorised once, as a dense matrix.
class DenseMarginals {
 public:
  DenseMarginals(const Graph& graph, const Values& values, char eliminate_first,
                 const SharedError& shared = {});

  // H^-1 M H^-1 (reduced.h), which is what marginal_covariance() says where no errors hang together; not of variables of the eliminated kind.
  std::optional<Eigen::MatrixXd> covariance(const std::vector<Key>& keys) const;

 private:
  struct Columns {
    int first = 0;
    int count = 0;
  };
  std::map<Key, Columns> columns_;
  Eigen::VectorXd scale_;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::MatrixXd M_;  // scaled
};

}  // namespace covey::graph
