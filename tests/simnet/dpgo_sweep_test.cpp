// SPDX-License-Identifier: BSD-3-Clause
// Seeded runs through everything at once (dpgo_sweep.h). COVEY_SEEDS=500 test_simnet_dpgo "seeded runs*" takes seeds 1 ... 500 and
// sums them up, COVEY_SEEDS=101-200 those alone; without it the first few.

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>

#include "tests/simnet/dpgo_sweep.h"

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

struct Seeds {
  int first = 1;
  int last = 30;
};

Seeds seeds_in(const char* words) {
  Seeds seeds;
  if (std::sscanf(words, "%d-%d", &seeds.first, &seeds.last) < 2) seeds = {1, std::atoi(words)};
  return seeds;
}

TEST_CASE("seeded runs end with all connected robots on the lossless result") {
  const char* asked = std::getenv("COVEY_SEEDS");
  const Seeds seeds = asked == nullptr ? Seeds{} : seeds_in(asked);
  REQUIRE(seeds.first > 0);
  REQUIRE(seeds.first <= seeds.last);
  Summary summary;
  for (int seed = seeds.first; seed <= seeds.last; ++seed) {
    const SweepRun run = run_seed(static_cast<std::uint64_t>(seed));
    summary.add(run);
    INFO("seed " << seed << ": " << run.story);
    CHECK(run.failure == "");
  }
  if (asked == nullptr) {
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
