// SPDX-License-Identifier: BSD-3-Clause
// Seeded runs through everything at once (dpgo_sweep.h); seeds.h says how to take others: COVEY_SEEDS=500 test_simnet_dpgo "seeded runs*"
// sums up seeds 1 ... 500.

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <iostream>
#include <string>

#include "tests/simnet/dpgo_sweep.h"
#include "tests/simnet/seeds.h"

namespace covey::pgo {
namespace {

struct Summary {
  int runs = 0;
  int failed = 0;
  int parted = 0;
  int with_relays = 0;
  int most_rounds = 0;
  double longest_s = 0.0;
  double cost_error = 0.0;

  void add(const SweepRun& run) {
    ++runs;
    failed += run.failure.empty() ? 0 : 1;
    parted += run.parted ? 1 : 0;
    with_relays += run.relayed > 0 ? 1 : 0;
    most_rounds = std::max(most_rounds, run.rounds);
    longest_s = std::max(longest_s, run.seconds);
    cost_error = std::max(cost_error, run.cost_error);
  }
};

TEST_CASE("seeded runs end with all connected robots on the lossless result") {
  const Seeds seeds = seeds_or(30);
  REQUIRE(seeds.first > 0);
  REQUIRE(seeds.first <= seeds.last);
  Summary summary;
  for (int seed = seeds.first; seed <= seeds.last; ++seed) {
    const SweepRun run = run_seed(static_cast<std::uint64_t>(seed));
    summary.add(run);
    INFO("seed " << seed << ": " << run.story);
    CHECK(run.failure == "");
  }
  if (!seeds.asked) {
    REQUIRE(summary.with_relays > 0);
    return;
  }
  std::cout << fmt::format(
      "{} runs, {} failed; {} ended in parts, {} with relays; at most {} rounds, {:.0f} s of their time, "
      "cost off by "
      "{:.1e}\n",
      summary.runs, summary.failed, summary.parted, summary.with_relays, summary.most_rounds,
      summary.longest_s, summary.cost_error);
}

}  // namespace
}  // namespace covey::pgo
