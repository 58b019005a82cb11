// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/chi_square.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace covey::pgo;

TEST_CASE("chi-square quantiles agree with printed tables") {
  CHECK(std::sqrt(chi_square_quantile(0.9, 6)) == Approx(3.263).epsilon(1e-3));
  CHECK(chi_square_quantile(0.99, 6) == Approx(16.8118938297).epsilon(1e-10));
  CHECK(chi_square_quantile(0.5, 6) == Approx(5.3481206274).epsilon(1e-9));
  CHECK(chi_square_quantile(0.99, 3) == Approx(11.3448667301).epsilon(1e-10));
  CHECK(chi_square_quantile(0.05, 3) == Approx(0.3518463177).epsilon(1e-9));
}
