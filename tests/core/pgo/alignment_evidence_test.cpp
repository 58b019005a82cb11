// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/alignment_evidence.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace covey::pgo;

TEST_CASE("evidence grows with the loops that agree, and falls with what chance brings together") {
  for (int k = 1; k < 30; ++k) {
    CHECK(log_evidence(k + 1, 30, 0.01, false) > log_evidence(k, 30, 0.01, false));
    CHECK(log_evidence(k, 30, 0.01, false) >= log_evidence(k, 30, 0.1, false));
    CHECK(log_evidence(k, 30, 0.01, false) >= log_evidence(k, 30, 0.01, true));
  }
}

TEST_CASE("as many as chance brings together say only that not all loops are right") {
  CHECK(log_evidence(0, 9, 0.01, false) == Approx(-std::log(10.0)));
  CHECK(log_evidence(3, 9, 0.4, false) == Approx(-std::log(10.0)));
  CHECK(log_evidence(2, 50, 0.02, true) == Approx(-std::log(51.0)));
  CHECK(log_evidence(0, 0, 0.01, true) == 0.0);
}

TEST_CASE("the bound is not below the binomial tail") {
  const int n = 20;
  const double q = 0.05;
  double tail = 0.0;
  for (int k = n; k > 1; --k) {
    tail += std::exp(std::lgamma(n + 1) - std::lgamma(k + 1) - std::lgamma(n - k + 1) + k * std::log(q) +
                     (n - k) * std::log1p(-q));
    CHECK(-log_evidence(k, n, q, false) - std::log1p(n) >= std::log(tail));
  }
}
