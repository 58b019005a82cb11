// SPDX-License-Identifier: BSD-3-Clause
// Robots that hear each other only through a third, or a third and a fourth: they end as if all heard all.

#include <catch2/catch.hpp>

#include "core/pgo/solve_distributed.h"
#include "core/sim/grid.h"
#include "tests/simnet/dpgo_team.h"

namespace covey::pgo {
namespace {

std::vector<int> everybody(const PoseGraph& graph) {
  std::vector<int> robots;
  for (int robot = 0; robot < graph.robots(); ++robot) robots.push_back(robot);
  return robots;
}

void require_solved_together(Team& team, const PoseGraph& graph, Utime limit) {
  REQUIRE(team.run_until_solved(limit));
  for (const auto& [robot, result] : team.results()) REQUIRE(result.robots == everybody(graph));
  REQUIRE(team.cost() == Approx(solve_distributed(graph).cost).epsilon(1e-3));
}

TEST_CASE("a team in which all hear all passes nothing on") {
  Team team(small_graph(), {.delay_us = 30'000});
  team.feed_all();
  require_solved_together(team, small_graph(), 60 * kSecond);
  REQUIRE(team.said().count("dpgo_relay_t") == 0);
}

TEST_CASE("the ends of a chain are solved together through the robot between them") {
  for (const double loss : {0.0, 0.3}) {
    Team team(small_graph(), {.loss = loss, .delay_us = 30'000});
    team.network().chain();
    team.feed_all();
    require_solved_together(team, small_graph(), 600 * kSecond);
  }
}

TEST_CASE("each message is passed on once for each hop") {
  Team team(small_graph(), {.delay_us = 30'000}, 1, 8 * kSecond);
  team.network().chain();
  team.feed_all();
  require_solved_together(team, small_graph(), 60 * kSecond);
  REQUIRE(team.results().at(0).name.number == 1);
  // Of the three robots' updates the middle one passes on those of the ends.
  const auto said = team.said();
  const int updates = said.at("dpgo_advance_t");
  REQUIRE(updates % 3 == 0);
  std::map<int, int> relayed;
  Team again(small_graph(), {.delay_us = 30'000}, 1, 8 * kSecond);
  again.network().chain();
  again.damage = [&](int from, const AgentMessage& message) -> std::optional<AgentMessage> {
    if (const auto* relay = std::get_if<dpgo_relay_t>(&message)) {
      if (std::holds_alternative<dpgo_advance_t>(*decode_message(relay->message))) ++relayed[from];
    }
    return std::nullopt;
  };
  again.feed_all();
  require_solved_together(again, small_graph(), 60 * kSecond);
  REQUIRE(relayed == std::map<int, int>{{1, updates * 2 / 3}});
}

PoseGraph five_robots() {
  return sim::make_grid({.robots = 5, .keyframes = 24, .seed = 3, .min_links = 3}).graph;
}

TEST_CASE("four hops are as good as one") {
  const PoseGraph graph = five_robots();
  for (const double loss : {0.0, 0.2}) {
    Team team(graph, {.loss = loss, .delay_us = 50'000});
    team.network().chain();
    team.feed_all();
    require_solved_together(team, graph, 900 * kSecond);
  }
}

// A ring: two ways around, of which only one is needed.
TEST_CASE("two robots between the same parts do not both pass on") {
  Team team(five_robots(), {.delay_us = 20'000}, 1, 8 * kSecond);
  team.network().partition({0}, {4});  // 1, 2 and 3 hear both
  std::map<int, int> relayed;
  team.damage = [&](int from, const AgentMessage& message) -> std::optional<AgentMessage> {
    if (team.now() > 5 * kSecond && std::holds_alternative<dpgo_relay_t>(message)) ++relayed[from];
    return std::nullopt;
  };
  team.feed_all();
  require_solved_together(team, five_robots(), 60 * kSecond);
  REQUIRE(relayed.size() == 1);
  REQUIRE(relayed.count(1) == 1);
}

TEST_CASE("a link that breaks in the middle of a round is replaced by a way around it") {
  Team team(small_graph(), {.delay_us = 30'000}, 1, 8 * kSecond);
  team.feed_all();
  run_into_a_round(team, 0);
  team.network().cut(0, 2);
  require_solved_together(team, small_graph(), 120 * kSecond);
  REQUIRE(team.results().at(0).name.number == 1);  // nobody counted as away
}

TEST_CASE("the robot between two others that leaves parts them, and joins them when it is back") {
  Team team(small_graph(), {.loss = 0.1, .delay_us = 30'000});
  team.network().chain();
  team.run_for(5 * kSecond);  // until the ends know of each other
  team.feed_all();
  run_into_a_round(team, 1);
  team.stop(1);
  team.run_for(10 * kSecond);
  REQUIRE(team.run_until_solved({0}, 120 * kSecond));
  REQUIRE(team.run_until_solved({2}, 120 * kSecond));
  for (const int robot : {0, 2}) {
    const auto apart = team.agent(robot).apart(team.now());
    REQUIRE(apart.size() == 2);
    for (const ApartRobot& other : apart) REQUIRE(other.why == Apart::kSilent);
  }
  team.start(1);
  team.feed(1);
  require_solved_together(team, small_graph(), 600 * kSecond);
  for (const int robot : {0, 1, 2}) REQUIRE(team.agent(robot).apart(team.now()).empty());
}

}  // namespace
}  // namespace covey::pgo
