// SPDX-License-Identifier: BSD-3-Clause
// Seeded runs through everything at once (lcd_sweep.h); seeds.h says how to take others.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <iostream>

#include "tests/simnet/lcd_sweep.h"
#include "tests/simnet/seeds.h"

namespace covey::place {
namespace {

TEST_CASE("seeded runs end with the same closures at both ends") {
  const Seeds seeds = seeds_or(20);
  REQUIRE(seeds.first > 0);
  REQUIRE(seeds.first <= seeds.last);
  int failed = 0;
  int closures = 0;
  int got = 0;
  int in_vain = 0;
  double longest_s = 0.0;
  for (int seed = seeds.first; seed <= seeds.last; ++seed) {
    const LcdSweepRun run = run_lcd_seed(static_cast<std::uint64_t>(seed));
    INFO("seed " << seed << ": " << run.story);
    CHECK(run.failure == "");
    failed += run.failure.empty() ? 0 : 1;
    closures += run.closures;
    got += run.radio ? run.bags_got : 0;
    in_vain += run.radio ? run.bags_in_vain : 0;
    longest_s = std::max(longest_s, run.seconds);
  }
  CHECK(closures > 10 * (seeds.last - seeds.first + 1));
  if (!seeds.asked) return;
  std::cout << fmt::format(
      "{} runs, {} failed; {} closures between robots; over radio links {} of {} bags came in vain; {:.0f} s "
      "of their time at most\n",
      seeds.last - seeds.first + 1, failed, closures, in_vain, got, longest_s);
}

}  // namespace
}  // namespace covey::place
