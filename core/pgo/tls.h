// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Truncated least squares, rho(r) = min(r^2, c^2), by graduated non-convexity: a surrogate that is convex for mu -> 0 and
// becomes rho for mu -> infinity is minimised by weighted least squares (weights: gnc_weight, core/graph/gnc.h).
// Source: Yang, Antonante, Tzoumas, Carlone, "Graduated Non-Convexity for Robust Spatial Perception", RA-L 2020, equation 14
// and remark 5.

#include <limits>

namespace covey::pgo {

// The mu at which the surrogate is still convex for residuals up to max_r2; infinite when none exceeds the threshold.
inline double tls_first_mu(double max_r2, double barc2) {
  const double margin = 2.0 * max_r2 - barc2;
  return max_r2 > barc2 ? barc2 / margin : std::numeric_limits<double>::infinity();
}

}  // namespace covey::pgo
