// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// (H + diag(damping)) x = b, for an H that changes little from one time to the next, as it does from step to step of
// Gauss-Newton near a minimum or from round to round of reweighting. The first time it is factorised; after that the factor
// preconditions conjugate gradients on the present H, until it is worn: until a solve with it takes more work than the solves
// since the factorisation have taken on average, the factorisation included. For core/graph's own sources.

#include <optional>

#include "core/graph/block_cholesky.h"

namespace covey::graph {

class DampedSystem {
 public:
  explicit DampedSystem(BlockCholesky matrix) : H(std::move(matrix)) {}

  // To about a hundredth of x in the norm of H where conjugate gradients do, exactly where a factorisation does. Nothing when
  // the sum is not positive definite.
  std::optional<Eigen::VectorXd> solve(const Eigen::VectorXd& b, const Eigen::VectorXd& damping);

  // The next solve will factorise.
  bool is_worn() const;

  BlockCholesky H;

 private:
  // In iterations, each of which is a solve with the factor.
  double price_of_factor() const;
  std::optional<Eigen::VectorXd> iterate(const Eigen::VectorXd& b, const Eigen::VectorXd& damping);

  bool has_factor_ = false;
  // Of the solves with this factor.
  int solves_ = 1;
  int last_iterations_ = 0;
  int total_iterations_ = 0;
};

}  // namespace covey::graph
