// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The normal equations of a graph at given values after some variables have been eliminated, each by itself: with H = J^T J and b = J^T r of the
// first-order model (linearise.h), e the eliminated variables and k the others,
//
//   H_kk - H_ke H_ee^-1 H_ek,   b_k - H_ke H_ee^-1 b_e
//
// where H_ee is block-diagonal, since no two eliminated variables share a factor (COVEY_CHECK). The result is dense: for many small variables that
// hang on a few others. Directions of an eliminated variable that its factors do not determine are dropped (pseudo-inverse).
//
// Where errors are not what a solve takes them for, H is not the inverse of its result's covariance. With M = E[b b^T] that is
//
//   C = H^-1 M H^-1
//
// M = H where each whitened residual has the covariance I. Here those of one eliminated variable may hang together (SharedError): what lasts is not averaged
// away by many of them, and does not come between two that follow one another shortly. Source: Huber, "The behavior of maximum likelihood estimates under
// nonstandard conditions", 1967; White, "Maximum likelihood estimation of misspecified models", Econometrica 1982.

#include <Eigen/Core>
#include <map>
#include <set>

#include "core/graph/graph.h"

namespace covey::graph {

struct ReducedSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  Eigen::MatrixXd M;
  std::map<Key, int> first_column;  // of each variable that is left, in key order; constant ones have none
};

// Of the whitened residuals of the factors of one eliminated variable, and of all of them together.
struct SharedError {
  // E[r_i r_i^T] = variance I, and of two of one series (Factor::occasion) that were measured t apart E[r_i r_j^T] = variance share e^(-t / memory_s) I.
  double variance = 1.0;
  double share = 0.0;
  double memory_s = 1.0;
  // In all of them: as if these variables were off by that much, tangent dimension x n, times n independent deviates.
  std::map<Key, Eigen::MatrixXd> common = {};
};

ReducedSystem reduce(const Graph& graph, const Values& values, const std::set<Key>& eliminated,
                     const SharedError& shared = {});

// H^-1 B of a positive semi-definite H, without the directions that H does not determine. Scaled to a unit diagonal first.
Eigen::MatrixXd solve_semidefinite(const Eigen::MatrixXd& H, const Eigen::MatrixXd& B);

}  // namespace covey::graph
