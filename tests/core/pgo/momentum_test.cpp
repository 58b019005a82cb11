// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/momentum.h"

#include <catch2/catch.hpp>

namespace covey::pgo {
namespace {

TEST_CASE("momentum starts from nothing, grows towards 1, and starts again") {
  Momentum momentum;
  REQUIRE(momentum.next() == 0.0);
  double before = 0.0;
  for (int n = 2; n < 100; ++n) {
    const double beta = momentum.next();
    REQUIRE(beta > before);
    REQUIRE(beta < 1.0);
    before = beta;
  }
  REQUIRE(before > 0.95);
  momentum.restart();
  REQUIRE(momentum.next() == 0.0);
}

}  // namespace
}  // namespace covey::pgo
