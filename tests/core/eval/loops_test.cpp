// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/loops.h"

#include <catch2/catch.hpp>

namespace covey {
namespace {

SE3 motion(double x_m, double yaw_deg) {
  return {SO3::exp({0.0, 0.0, yaw_deg * M_PI / 180.0}), {x_m, 0.0, 0.0}};
}

TEST_CASE("a closure is right within both limits") {
  CHECK(is_right_closure(motion(5.9, 99.0), motion(5.0, 90.0)));
  CHECK_FALSE(is_right_closure(motion(6.1, 90.0), motion(5.0, 90.0)));
  CHECK_FALSE(is_right_closure(motion(5.0, 101.0), motion(5.0, 90.0)));
  CHECK(is_right_closure(motion(6.1, 90.0), motion(5.0, 90.0), {.translation_m = 2.0, .rotation_deg = 1.0}));
}

TEST_CASE("closures are counted by pair, whichever end comes first") {
  const LoopScore score = score_loops(
      {
          {.robot_a = 0, .robot_b = 1, .kept = true, .right = true},
          {.robot_a = 1, .robot_b = 0, .kept = false, .right = true},
          {.robot_a = 0, .robot_b = 1, .kept = true, .right = false},
          {.robot_a = 2, .robot_b = 2, .kept = true, .right = true},
      },
      3);
  REQUIRE(score.pairs.size() == 6);
  CHECK(score.pairs[1].a == 0);
  CHECK(score.pairs[1].b == 1);
  CHECK(score.pairs[1].total == 3);
  CHECK(score.pairs[1].kept == 2);
  CHECK(score.pairs[1].right == 2);
  CHECK(score.pairs[1].kept_right == 1);
  CHECK(score.pairs[5].total == 1);
  CHECK(score.pairs[0].total == 0);
  CHECK(score.precision.value() == Approx(2.0 / 3.0));
  CHECK(score.recall.value() == Approx(2.0 / 3.0));
}

TEST_CASE("without truth there is no precision and no recall") {
  const LoopScore score = score_loops({{.robot_a = 0, .robot_b = 1, .kept = true, .right = {}}}, 2);
  CHECK(score.sum.kept == 1);
  CHECK_FALSE(score.sum.truth_known);
  CHECK_FALSE(score.precision);
  CHECK_FALSE(score.recall);
  CHECK_FALSE(score_loops({}, 2).precision);
}

}  // namespace
}  // namespace covey
