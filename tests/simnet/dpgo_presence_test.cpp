// SPDX-License-Identifier: BSD-3-Clause
// Robots that part, leave, are restarted and come back: whoever hears each other ends in one frame at the same optimum, and who
// is apart is named.

#include <catch2/catch.hpp>
#include <string>

#include "core/pgo/solve_distributed.h"
#include "tests/simnet/dpgo_team.h"

namespace covey::pgo {
namespace {

TEST_CASE("parted teams solve apart, and together when they meet") {
  Team team(small_graph(), {.loss = 0.1, .delay_us = 30'000});
  team.network().isolate(2);
  team.feed_all();
  team.run_for(60 * kSecond);
  REQUIRE(team.results().at(0).robots == std::vector<int>{0, 1});
  REQUIRE(team.results().at(2).robots == std::vector<int>{2});
  team.network().heal();
  REQUIRE(team.run_until_solved(300 * kSecond));
  for (const auto& [robot, result] : team.results()) {
    REQUIRE(result.robots == std::vector<int>{0, 1, 2});
    REQUIRE(result.anchor == 0);
  }
  REQUIRE(team.cost() == Approx(solve_distributed(small_graph()).cost).epsilon(1e-3));
}

TEST_CASE("a robot that is killed in a round and started anew takes part again") {
  for (const int victim : {0, 1, 2}) {
    Team team(small_graph(), {.loss = 0.1, .delay_us = 30'000});
    team.feed_all();
    run_into_a_round(team, victim);
    team.stop(victim);
    team.network().restart(victim);
    team.run_for(kSecond);
    team.start(victim);
    team.feed(victim);
    REQUIRE(team.run_until_solved(300 * kSecond));
    REQUIRE(team.results().at(victim).robots == std::vector<int>{0, 1, 2});
    REQUIRE(team.cost() == Approx(solve_distributed(small_graph()).cost).epsilon(1e-3));
  }
}

TEST_CASE("a robot that falls silent for good is left out, and the others finish") {
  Team team(small_graph(), {.loss = 0.1, .delay_us = 30'000});
  team.feed_all();
  run_into_a_round(team, 0);
  team.stop(0);
  REQUIRE(team.run_until_solved(300 * kSecond));
  for (const int robot : {1, 2}) REQUIRE(team.results().at(robot).robots == std::vector<int>{1, 2});
  REQUIRE(team.results().at(1).anchor == 1);
}

// Runs until robot 0 has ended a round that robot 1 has not, for want of a message of robot `of` alone.
bool run_until_last_message_is_missing(Team& team, int of) {
  while (team.results().count(0) == 0) {
    team.run_for(20'000);
    REQUIRE(team.now() < 600 * kSecond);
  }
  return team.agent(1).phase() == AgentPhase::kRound &&
         team.agent(1).round()->name() == team.results().at(0).name &&
         team.agent(1).round()->missing() == std::vector<int>{of};
}

TEST_CASE("a robot that leaves with the last message of a round leaves nobody waiting for it") {
  int tried = 0;
  for (std::uint64_t seed = 1; tried < 3; ++seed) {
    REQUIRE(seed < 100);
    Team team(small_graph(), {.loss = 0.4, .delay_us = 30'000}, seed, 8 * kSecond);
    team.feed_all();
    if (!run_until_last_message_is_missing(team, 2)) continue;
    team.stop(2);
    team.run_for(kSecond / 10);
    if (team.agent(1).phase() != AgentPhase::kRound) continue;  // it was in the air
    ++tried;
    team.network().set_faults({.delay_us = 30'000});  // else silence by chance would end it one day
    REQUIRE(team.run_until_solved(60 * kSecond));
    for (const int robot : {0, 1}) REQUIRE(team.results().at(robot).robots == std::vector<int>{0, 1});
  }
}

TEST_CASE("a robot that is restarted right after a round leaves nobody waiting for its end") {
  int tried = 0;
  for (std::uint64_t seed = 1; tried < 3; ++seed) {
    REQUIRE(seed < 100);
    Team team(small_graph(), {.loss = 0.4, .delay_us = 30'000}, seed, 8 * kSecond);
    team.feed_all();
    if (!run_until_last_message_is_missing(team, 0)) continue;
    const Solution solution = team.agent(0).solution();
    team.stop(0);
    team.run_for(kSecond / 10);
    if (team.agent(1).phase() != AgentPhase::kRound) continue;  // it was in the air
    ++tried;
    team.network().set_faults({.delay_us = 30'000});  // else silence by chance would end it one day
    team.start(0);
    team.feed(0);
    team.agent(0).restore(solution);
    REQUIRE(team.run_until_solved(60 * kSecond));
    REQUIRE(team.results().at(0).name.number > solution.round.number);
    REQUIRE(team.results().at(0).robots == std::vector<int>{0, 1, 2});
  }
}

TEST_CASE("a robot without keyframes has nothing to wait for") {
  Team team(small_graph(), {});
  team.feed(0);
  team.feed(1);
  team.run_for(30 * kSecond);
  REQUIRE(team.agent(2).phase() == AgentPhase::kIdle);
  REQUIRE(team.results().at(0).robots == std::vector<int>{0, 1});
}

TEST_CASE("rounds of one name before and after a restart without memory leave frames of two names") {
  Team team(small_graph(), {}, 1, 8 * kSecond);
  team.feed_all();
  REQUIRE(team.run_until_solved(100 * kSecond));
  team.network().isolate(2);
  for (const int robot : {0, 1}) {
    team.stop(robot);
    team.restart_odometry(robot);
  }
  for (const int robot : {0, 1}) {
    team.start(robot);
    team.feed(robot);
  }
  team.run_for(60 * kSecond);
  REQUIRE(team.agent(0).solution().round == team.agent(2).solution().round);
  REQUIRE(team.agent(0).solution().frame != team.agent(2).solution().frame);
  team.network().heal();
  team.feed(2);
  REQUIRE(team.run_until_solved(100 * kSecond));
  REQUIRE(team.results().at(2).robots == std::vector<int>{0, 1, 2});
  REQUIRE(team.cost() == Approx(solve_distributed(small_graph()).cost).epsilon(1e-3));
}

}  // namespace
}  // namespace covey::pgo
