// SPDX-License-Identifier: BSD-3-Clause
// Distributed optimisation on a network that loses, delays, doubles and disorders: the result is that of the perfect network,
// to the last bit. Clocks that are set back, and members that send nonsense, hold nobody up.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "core/pgo/solve_distributed.h"
#include "tests/simnet/dpgo_team.h"
#include "tests/simnet/dpgo_vandal.h"

namespace covey::pgo {
namespace {

void require_identical(const std::map<int, RoundResult>& a, const std::map<int, RoundResult>& b) {
  REQUIRE(a.size() == b.size());
  for (const auto& [robot, result] : a) {
    const RoundResult& other = b.at(robot);
    REQUIRE(result.updates == other.updates);
    REQUIRE(result.segments.size() == other.segments.size());
    for (std::size_t s = 0; s < result.segments.size(); ++s) {
      REQUIRE(result.segments[s].T_W_K.size() == other.segments[s].T_W_K.size());
      for (std::size_t k = 0; k < result.segments[s].T_W_K.size(); ++k) {
        const SE3& T = result.segments[s].T_W_K[k];
        const SE3& U = other.segments[s].T_W_K[k];
        REQUIRE(T.translation == U.translation);
        REQUIRE(T.rotation.quaternion().coeffs() == U.rotation.quaternion().coeffs());
      }
    }
    REQUIRE(result.owned_cost == other.owned_cost);
  }
}

std::map<int, RoundResult> solve(LinkFaults faults, std::uint64_t seed) {
  // Settles long enough for everybody to hear of everybody, so that there is one round.
  Team team(small_graph(), faults, seed, 8 * kSecond);
  team.feed_all();
  REQUIRE(team.run_until_solved(600 * kSecond));
  REQUIRE(team.results().at(0).name.number == 1);
  return team.results();
}

TEST_CASE("loss, delay, doubles and disorder change nothing in the result") {
  const auto perfect = solve({}, 1);
  require_identical(perfect, solve({.loss = 0.2, .delay_us = 100'000}, 2));
  require_identical(perfect,
                    solve({.loss = 0.4, .delay_us = 50'000, .jitter_us = 400'000, .duplicate = 0.3}, 3));
}

// A team that is told that it drives in the plane, and goes along smooth motions as soon as weights are binary.
std::map<int, RoundResult> solve_planar(LinkFaults faults, std::uint64_t seed) {
  Team team(small_graph(), faults, seed, 8 * kSecond);
  DgncOptions planar;
  planar.alignment.dimension = 2;
  planar.coarse_after = 1;
  for (const int robot : {0, 1, 2}) team.start(robot, planar);
  team.feed_all();
  REQUIRE(team.run_until_solved(600 * kSecond));
  REQUIRE(team.said().count("dpgo_coarse_t") == 1);
  return team.results();
}

TEST_CASE("nor do they where a planar team takes steps along smooth motions") {
  const auto perfect = solve_planar({}, 1);
  require_identical(perfect, solve_planar({.loss = 0.3, .delay_us = 50'000, .jitter_us = 200'000}, 2));
}

TEST_CASE("agents reach what the solver without a network reaches") {
  const DistributedResult direct = solve_distributed(small_graph());
  const auto over_the_air = solve({}, 1);
  double cost = 0.0;
  int kept = 0;
  for (const auto& [robot, result] : over_the_air) {
    cost += result.owned_cost;
    kept += result.owned_kept;
  }
  REQUIRE(cost == Approx(direct.cost).epsilon(1e-6));
  REQUIRE(kept == direct.kept);
}

TEST_CASE("a clock that is set back holds nobody up") {
  for (const int robot : {0, 1, 2}) {
    Team team(small_graph(), {.loss = 0.1, .delay_us = 30'000});
    team.run_for(150 * kSecond);
    team.feed_all();
    run_into_a_round(team, robot);
    team.set_back_clock(robot, 150 * kSecond);
    REQUIRE(team.run_until_solved(60 * kSecond));
    for (const auto& [member, result] : team.results()) REQUIRE(result.robots == std::vector<int>{0, 1, 2});
    const std::int64_t round = team.results().at(0).name.number;
    team.run_for(20 * kSecond);
    REQUIRE(team.results().at(0).name.number == round);
  }
}

TEST_CASE("round numbers at the end of their range are refused and never count over") {
  DgncAgent agent(0, 1, {});
  dpgo_beacon_t beacon{};
  beacon.from = 1;
  beacon.round = std::numeric_limits<std::int64_t>::max();
  REQUIRE(agent.receive(beacon, 0) == std::string("values"));
}

TEST_CASE("a member that sends nonsense ends nobody, and nothing infinite comes of it") {
  int results = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Vandal vandal(seed);
    Team team(small_graph(), {});
    team.feed_all();
    team.damage = [&](int from, const AgentMessage& message) -> std::optional<AgentMessage> {
      if (from != 2 || !vandal.strikes()) return std::nullopt;
      return std::visit(vandal, message);
    };
    team.run_for(40 * kSecond);
    results += static_cast<int>(team.results().size());
    for (const auto& [robot, result] : team.results()) {
      REQUIRE(std::isfinite(result.owned_cost));
      for (const SegmentResult& segment : result.segments) {
        for (const SE3& T : segment.T_W_K) REQUIRE(T.translation.allFinite());
      }
    }
  }
  REQUIRE(results > 0);
}

}  // namespace
}  // namespace covey::pgo
