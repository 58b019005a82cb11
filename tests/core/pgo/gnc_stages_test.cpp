// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/gnc_stages.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <utility>

#include "core/graph/gnc.h"

namespace covey::pgo {
namespace {

constexpr TeamUpdate kFalling{100.0, 50.0, 3};
constexpr TeamUpdate kStill{100.0, 0.0, 3};
constexpr TeamUpdate kDecided{100.0, 50.0, 0};

TEST_CASE(
    "a stage ends after its updates, or when the cost falls little for the loops that are undecided, or none "
    "is") {
  GncStages stages({.barc2 = 10.0, .updates = 2, .tolerance = 0.01});
  REQUIRE(stages.ended(kFalling));  // none has begun
  REQUIRE(stages.begin(kFalling, 0.1));
  REQUIRE_FALSE(stages.ended(kFalling));
  REQUIRE(stages.ended(kStill));
  REQUIRE(stages.ended({100.0, 0.29, 3}));
  REQUIRE_FALSE(stages.ended({100.0, 0.31, 3}));
  REQUIRE(stages.ended(kDecided));
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

TEST_CASE("without a step mu is binary in ten stages, however small the first one") {
  for (const double first : {1e-12, 1e-5, 0.003, 0.1, 3.0}) {
    GncStages stages(DgncOptions{});
    double before = 0.0;
    while (!stages.binary()) {
      REQUIRE(stages.begin(kStill, first));
      REQUIRE(stages.mu() > before);
      before = stages.mu();
    }
    REQUIRE(stages.stages() <= 10);
    REQUIRE((first < graph::kMuOfDecisions) == (stages.stages() == 10));
  }
}

TEST_CASE("loops are weighed before each update once mu decides, and once a stage before and after") {
  for (const auto& [mu, each_time] : {std::pair(0.001, false), std::pair(0.1, true), std::pair(1e9, false)}) {
    GncStages stages(DgncOptions{});
    REQUIRE(stages.begin(kStill, mu));
    REQUIRE(stages.weighs());
    stages.count_update();
    REQUIRE(stages.weighs() == each_time);
  }
}

TEST_CASE("what a weight adds to the cost makes it the best one for its residual") {
  GncStages stages({.barc2 = 4.0});
  REQUIRE(stages.begin(kStill, 0.1));
  for (const double r2 : {0.1, 1.0, 3.0, 10.0, 40.0, 50.0}) {
    const auto surrogate = [&](double weight) { return weight * r2 + stages.penalty(weight); };
    const double best = stages.weight(r2);
    for (double other = 0.0; other <= 1.0; other += 0.01)
      REQUIRE(surrogate(best) <= surrogate(other) + 1e-12);
  }
  REQUIRE(stages.penalty(1.0) == 0.0);
  REQUIRE(stages.penalty(0.0) == Approx(4.0));
}

TEST_CASE("a second binary stage in which nothing changed sides is the last") {
  GncStages stages({.final_stages = 10});
  constexpr TeamUpdate kDone{100.0, 0.0, 0};
  REQUIRE(stages.begin(kDone, std::numeric_limits<double>::infinity()));
  REQUIRE(stages.begin(kDone, 0.0));
  REQUIRE_FALSE(stages.begin(kDone, 0.0));
}

TEST_CASE("least squares have one stage") {
  GncStages stages({.robust = false});
  REQUIRE(stages.begin(kStill, 0.1));
  REQUIRE_FALSE(stages.begin(kStill, 0.1));
}

}  // namespace
}  // namespace covey::pgo
