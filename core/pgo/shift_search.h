// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The smallest shift eta of a matrix S over the poses of a graph for which S + eta blockdiag(I_d, 0, ...) is positive definite,
// between two bounds that are both proven: a factorisation that goes through says that an eta is enough, a vector of negative
// curvature that less is not.

#include <Eigen/Core>
#include <cstdint>

#include "core/pgo/team_matrix.h"

namespace covey::pgo {

class ShiftSearch {
 public:
  ShiftSearch(const SeparatedGraph& team, TeamMatrix& S);

  // In [low, high] to a relative accuracy; `high` is enough without a trial.
  double find(double low, double high, double accuracy);

  int trials() const { return trials_; }
  std::int64_t bytes() const { return bytes_; }  // sent for it between robots, beside those of S

 private:
  struct Needed {
    double eta = 0.0;
    bool sharp = false;  // some eigenvalue is that near, most likely the lowest
  };

  bool is_enough(double eta);
  Needed lanczos(double eta, double accuracy);
  Eigen::VectorXd rotations_of(Eigen::VectorXd x) const;

  const SeparatedGraph& team_;
  TeamMatrix& S_;
  int d_;
  Eigen::VectorXd x_;  // where Lanczos' method begins
  int trials_ = 0;
  std::int64_t bytes_ = 0;
};

}  // namespace covey::pgo
