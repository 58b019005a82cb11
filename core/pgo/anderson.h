// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Anderson's acceleration of a fixed-point iteration x -> G(x): with the steps f_k = G(x_k) - x_k of the last iterations, go on
// from the combination of their results whose steps, combined alike, are the shortest,
//
//   x = sum_k a_k G(x_k),   a = argmin |sum_k a_k f_k|^2  with  sum_k a_k = 1.
//
// On a quadratic that is what a Krylov method does, so a few slow directions cost a few iterations each. Only inner products
// of the steps are needed, which a team can sum. Source: Walker, Ni, "Anderson Acceleration for Fixed-Point Iterations",
// SIAM J. Numerical Analysis 2011.

#include <Eigen/Core>
#include <vector>

namespace covey::pgo {

class Anderson {
 public:
  explicit Anderson(int window) : window_(window) {}  // steps that are looked back at; 0: none

  void restart() { gram_.resize(0, 0); }
  // f_new . f_new, f_new . f_(the one before), ...; as many as there are steps since the last restart, at most window + 1.
  void add(const std::vector<double>& products);
  int steps() const { return static_cast<int>(gram_.rows()); }
  int window() const { return window_; }

  // a, newest first; {1} when there is nothing to combine.
  std::vector<double> coefficients() const;

 private:
  int window_;
  Eigen::MatrixXd gram_;  // newest first
};

}  // namespace covey::pgo
