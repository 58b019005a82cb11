// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/rejected_pairs.h"

#include <catch2/catch.hpp>

namespace covey::pgo {
namespace {

LoopResult loop(int a, int b, double weight, double r2) {
  LoopResult result;
  result.loop.a = {a, 1, 5};
  result.loop.b = {b, 1, 7};
  result.weight = weight;
  result.r2 = r2;
  return result;
}

TEST_CASE("a pair with nothing left between them is named with the residuals that did it") {
  const auto pairs = rejected_pairs({loop(0, 2, 0.0, 450.0), loop(2, 0, 0.0, 120.0), loop(0, 1, 1.0, 3.0),
                                     loop(0, 1, 0.0, 99.0), loop(0, 0, 1.0, 1.0), loop(0, 3, 0.5, 20.0)},
                                    0);
  REQUIRE(pairs.size() == 1);
  REQUIRE(sentence(pairs[0], 16.81) ==
          "All closures of pair 0-2 were rejected: 2, with squared residuals 120 450 against barc^2 16.81; "
          "robot 0 has "
          "kept 1 with itself, 1 with robot 1, 1 with robot 3");
}

TEST_CASE("a lone closure is named with its keyframes") {
  const auto pairs = rejected_pairs({loop(2, 0, 0.0, 120.0)}, 2);
  REQUIRE(pairs.size() == 1);
  REQUIRE(sentence(pairs[0], 16.81) ==
          "All closures of pair 0-2 were rejected: the only one, of keyframe 5 of robot 2 with keyframe 7 of "
          "robot 0, "
          "with squared residual 120 against barc^2 16.81; robot 2 has kept none with anybody");
}

TEST_CASE("of many residuals the smallest and the last are said") {
  std::vector<LoopResult> loops;
  for (int k = 1; k <= 20; ++k) loops.push_back(loop(0, 1, 0.0, 100.0 * k));
  REQUIRE(sentence(rejected_pairs(loops, 0).at(0), 16.81).find("900 1000 ... 2000 against") !=
          std::string::npos);
}

}  // namespace
}  // namespace covey::pgo
