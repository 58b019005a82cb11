// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/alignment_evidence.h"

#include <algorithm>
#include <cmath>

namespace covey::pgo {

double log_evidence(double inliers, int loops, double chance, bool searched) {
  if (loops <= 0) return 0.0;
  const double lambda = loops * chance;
  double log_probability = 0.0;
  if (inliers > lambda) log_probability = inliers - lambda - inliers * std::log(inliers / lambda);
  if (searched) log_probability = std::min(0.0, log_probability + std::log(loops));
  return -std::log1p(loops) - log_probability;
}

}  // namespace covey::pgo
