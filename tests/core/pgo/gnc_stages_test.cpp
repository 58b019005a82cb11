// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/gnc_stages.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/graph/gnc.h"

namespace covey::pgo {
namespace {

constexpr TeamUpdate kFalling{100.0, 50.0, 3};
constexpr TeamUpdate kStill{100.0, 0.0, 3};
constexpr TeamUpdate kDecided{100.0, 50.0, 0};

TEST_CASE(
    "a stage ends after its updates, or when the cost falls little for itself or the loops that are "
    "undecided, or none is") {
  GncStages stages({.barc2 = 10.0, .updates = 2, .tolerance = 0.001, .undecided_tolerance = 0.01});
  REQUIRE(stages.ended(kFalling));  // none has begun
  REQUIRE(stages.begin(kFalling, 0.1));
  REQUIRE_FALSE(stages.ended(kFalling));
  REQUIRE(stages.ended(kStill));
  REQUIRE(stages.ended({100.0, 0.29, 3}));
  REQUIRE_FALSE(stages.ended({100.0, 0.31, 3}));
  REQUIRE(stages.ended({500.0, 0.39, 3, 0.0, 100.0}));
  REQUIRE_FALSE(stages.ended({500.0, 0.41, 3, 0.0, 100.0}));
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

TEST_CASE("without a step mu is binary in eight stages, however small the first one") {
  for (const double first : {1e-12, 1e-5, 0.003, 0.1, 3.0}) {
    GncStages stages(DgncOptions{});
    double before = 0.0;
    while (!stages.binary()) {
      REQUIRE(stages.begin(kStill, first));
      do {
        REQUIRE(stages.mu() > before);
        before = stages.mu();
        stages.count_update();
      } while (stages.mu_rose());
    }
    REQUIRE(stages.stages() <= 8);
    REQUIRE((first < graph::kMuOfDecisions) == (stages.stages() == 8));
  }
}

TEST_CASE("mu rises with every update to where it decides, in the first stage") {
  GncStages stages(DgncOptions{});
  REQUIRE(stages.begin(kStill, 1e-5));
  int updates = 0;
  for (; stages.mu() < graph::kMuOfDecisions; ++updates) {
    REQUIRE_FALSE(stages.ended(kStill));
    REQUIRE(stages.weighs());
    stages.count_update();
    REQUIRE(stages.mu_rose());
  }
  REQUIRE(updates == 4);
  stages.count_update();
  REQUIRE_FALSE(stages.mu_rose());
  REQUIRE(stages.ended(kStill));
  REQUIRE(stages.stages() == 1);
}

TEST_CASE("the last fifth of a limited number of updates has binary weights") {
  GncStages stages({.total_updates = 10});
  constexpr TeamUpdate kFar{100.0, 50.0, 3};
  REQUIRE(stages.begin(kFar, 0.1));
  for (int update = 0; update < 8; ++update) {
    REQUIRE_FALSE(stages.ended(kFar));
    stages.count_update();
  }
  REQUIRE(stages.ended(kFar));
  REQUIRE(stages.begin(kFar, 0.0));
  REQUIRE(stages.binary());
  stages.count_update();
  REQUIRE_FALSE(stages.ended(kFar));
  stages.count_update();
  REQUIRE(stages.ended(kFar));
  REQUIRE_FALSE(stages.begin(kFar, 0.0));
}

TEST_CASE(
    "loops are weighed before each update until weights are binary, by fixed steps only once mu decides") {
  for (const auto& [mu, step, each_time] :
       {std::tuple(0.001, 0.0, true), std::tuple(0.001, 1.4, false), std::tuple(0.1, 1.4, true),
        std::tuple(0.1, 0.0, true), std::tuple(1e9, 0.0, false)}) {
    GncStages stages({.mu_step = step});
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
