// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Nesterov's momentum: before update n, go on by beta_n times the last step, beta_n = (t_n - 1) / t_{n+1},
// t_{n+1} = (1 + sqrt(1 + 4 t_n^2)) / 2, t_1 = 1. Source: Nesterov, "A method for solving the convex programming problem with
// convergence rate O(1/k^2)", 1983; restarted as in O'Donoghue, Candes, "Adaptive Restart for Accelerated Gradient
// Schemes", 2015.

#include <cmath>
#include <utility>

namespace covey::pgo {

class Momentum {
 public:
  void restart() { t_ = 1.0; }  // the next update starts from where it is
  double next() {               // beta
    const double next_t = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * t_ * t_));
    const double t = std::exchange(t_, next_t);
    return (t - 1.0) / next_t;
  }

 private:
  double t_ = 1.0;
};

}  // namespace covey::pgo
