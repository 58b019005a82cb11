// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/gnc_stages.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace covey::pgo {
namespace {

constexpr TeamUpdate kFalling{100.0, 50.0, 3};
constexpr TeamUpdate kStill{100.0, 0.0, 3};
constexpr TeamUpdate kDecided{100.0, 0.0, 0};

TEST_CASE("a stage ends after its updates, or when the cost falls no more") {
  GncStages stages({.updates = 2});
  REQUIRE(stages.ended(kFalling));  // none has begun
  REQUIRE(stages.begin(kFalling, 0.1));
  REQUIRE_FALSE(stages.ended(kFalling));
  REQUIRE(stages.ended(kStill));
  stages.count_update();
  stages.count_update();
  REQUIRE(stages.ended(kFalling));
}

TEST_CASE("mu grows by its step until it is beyond its limit, then weights are binary and stages few") {
  GncStages stages({.barc2 = 1.0, .mu_step = 2.0, .mu_max = 1.0, .final_stages = 3});
  REQUIRE(stages.begin(kStill, 0.6));
  REQUIRE(stages.weight(1.2) == Approx(std::sqrt(0.6 * 1.6 / 1.2) - 0.6));
  REQUIRE(stages.undecided(0.5, 0.5));
  REQUIRE(stages.begin(kStill, 0.6));
  REQUIRE(stages.mu() == 1.2);
  REQUIRE(stages.weight(0.99) == 1.0);
  REQUIRE(stages.weight(1.01) == 0.0);
  REQUIRE(stages.undecided(1.0, 0.0));
  REQUIRE_FALSE(stages.undecided(1.0, 1.0));
  REQUIRE(stages.begin(kStill, 0.6));
  REQUIRE(stages.begin(kStill, 0.6));
  REQUIRE_FALSE(stages.begin(kStill, 0.6));
  REQUIRE(stages.stages() == 4);
}

TEST_CASE("a second binary stage in which nothing changed sides is the last") {
  GncStages stages({.final_stages = 10});
  REQUIRE(stages.begin(kDecided, std::numeric_limits<double>::infinity()));
  REQUIRE(stages.begin(kDecided, 0.0));
  REQUIRE_FALSE(stages.begin(kDecided, 0.0));
}

TEST_CASE("least squares have one stage") {
  GncStages stages({.robust = false});
  REQUIRE(stages.begin(kStill, 0.1));
  REQUIRE_FALSE(stages.begin(kStill, 0.1));
}

}  // namespace
}  // namespace covey::pgo
