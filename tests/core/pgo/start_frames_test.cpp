// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/start_frames.h"

#include <catch2/catch.hpp>

namespace covey::pgo {
namespace {

PairAlignment aligned(int a, int b, double x) {
  PairAlignment pair{a, b, {}};
  pair.alignment.T_A_B = SE3{SO3{}, {x, 0.0, 0.0}};
  pair.alignment.inliers = 5;
  pair.alignment.ok = true;
  return pair;
}

StartFrames four_frames() {
  StartFrames frames;
  frames.add({1, 0}, 0);
  frames.add({1, 1}, 7);
  frames.add({2, 0}, 7);
  frames.add({4, 0}, 0);
  return frames;
}

TEST_CASE("frames of one solution coincide, aligned ones follow, and W is the anchor's that reaches most") {
  StartFrames frames = four_frames();
  REQUIRE(frames.same_solution({1, 1}, {2, 0}));
  REQUIRE_FALSE(frames.same_solution({1, 0}, {4, 0}));  // both none
  REQUIRE(frames.place({aligned(2, 3, 3.0)}, 4) == std::vector<int>{1, 2, 4});
  REQUIRE(frames.root() == StartFrame{1, 1});
  REQUIRE_FALSE(frames.pose_of({1, 0}));
  REQUIRE(frames.pose_of({2, 0})->translation.x() == 0.0);
  REQUIRE(frames.pose_of({4, 0})->translation.x() == Approx(3.0));
}

TEST_CASE("closures are believed before an earlier solution, which holds where they say nothing") {
  StartFrames frames;
  for (const int robot : {1, 2, 3}) frames.add({robot, 0}, 7);
  REQUIRE(frames.place({aligned(0, 1, 3.0)}, 1) == std::vector<int>{1, 2, 3});
  REQUIRE(frames.pose_of({2, 0})->translation.x() == 3.0);
  REQUIRE(frames.pose_of({3, 0})->translation.x() == 0.0);
  REQUIRE_FALSE(frames.unmoved());
  REQUIRE(frames.place({aligned(0, 1, 0.0)}, 1) == std::vector<int>{1, 2, 3});
  REQUIRE(frames.unmoved());
}

TEST_CASE("who is aligned with nobody is a part of its own") {
  StartFrames frames = four_frames();
  REQUIRE(frames.place({}, 4) == std::vector<int>{4});
  REQUIRE(frames.root() == StartFrame{4, 0});
  REQUIRE_FALSE(frames.has({4, 1}));
}

}  // namespace
}  // namespace covey::pgo
