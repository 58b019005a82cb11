// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Robust kernels. A factor costs rho(s), s = |whitened residual|^2, without a factor 1/2; w is the kernel's
// width in units of the whitened residual:
//
//   none     rho(s) = s
//   Huber    rho(s) = s up to s = w^2, then 2 w sqrt(s) - w^2
//   Cauchy   rho(s) = w^2 log(1 + s / w^2)

namespace covey::graph {

struct Robust {
  enum class Kind { kNone, kHuber, kCauchy };

  Kind kind = Kind::kNone;
  double width = 1.0;

  static Robust huber(double width) { return {Kind::kHuber, width}; }
  static Robust cauchy(double width) { return {Kind::kCauchy, width}; }

  double cost(double squared) const;
  double derivative(double squared) const;         // rho', the weight of reweighted least squares
  double second_derivative(double squared) const;  // rho''
};

}  // namespace covey::graph
