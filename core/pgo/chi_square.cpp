// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/chi_square.h"

#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

// Closed forms of the regularised incomplete gamma function P(k / 2, x / 2) for k = 3 and k = 6.
double chi_square_cdf(double x, int degrees_of_freedom) {
  const double h = 0.5 * x;
  if (degrees_of_freedom == 3)
    return std::erf(std::sqrt(h)) - 2.0 * std::sqrt(h / std::numbers::pi) * std::exp(-h);
  return 1.0 - std::exp(-h) * (1.0 + h + 0.5 * h * h);
}

}  // namespace

double chi_square_quantile(double probability, int degrees_of_freedom) {
  COVEY_CHECK(degrees_of_freedom == 3 || degrees_of_freedom == 6);
  COVEY_CHECK(probability > 0.0 && probability < 1.0);
  double low = 0.0;
  double high = 1.0;
  while (chi_square_cdf(high, degrees_of_freedom) < probability && high < 1e3) high *= 2.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (chi_square_cdf(middle, degrees_of_freedom) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace covey::pgo
