// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/words.h"

#include <catch2/catch.hpp>

namespace covey {
namespace {

using pgo::Apart;

TEST_CASE("who is apart is named, and why") {
  REQUIRE(team_line({0, 1, 4},
                    {{2, Apart::kSilent, false, 12'300'000}, {3, Apart::kNoClosure, false, 100'000}}) ==
          "robots 0 1 4 are solved together; 2 is apart: not heard for 12 s; 3 is apart: no closure with the "
          "others");
  REQUIRE(team_line({1}, {{0, Apart::kNotYet, false, 0}, {1, Apart::kSilent, true, 7'000'000}}) ==
          "robot 1 is solved alone; 0 is new: the next round will have it; 1 is away: not heard for 7 s");
}

TEST_CASE("a round is one line") {
  pgo::RoundResult result;
  result.name = {3, 0};
  result.robots = {0, 2};
  result.owned_cost = 41.25;
  result.gradient = 0.00234;
  result.weights_zero = 5;
  result.weights_one = 31;
  result.updates = 60;
  result.stages = 9;
  pgo::RoundAccount account;
  account.duration_us = 3'140'000;
  account.bytes = {{"dpgo_advance_t", 47'000}, {"dpgo_join_t", 1'200}};
  REQUIRE(round_line(result, account) ==
          "round 3 of robots 0 2: cost 41.25, gradient 0.00234, weights 5 at 0 / 0 between / 31 at 1, 60 "
          "updates in 9 "
          "stages, 48.2 kB, 3.1 s");
}

}  // namespace
}  // namespace covey
