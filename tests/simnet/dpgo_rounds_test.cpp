// SPDX-License-Identifier: BSD-3-Clause
// What rounds begin from and what they agree on: earlier solutions, closures that only one end knows, other options.

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "core/pgo/solve_distributed.h"
#include "tests/simnet/dpgo_team.h"

namespace covey::pgo {
namespace {

TEST_CASE("new keyframes and loops open a new round that goes on from the last one") {
  Team team(small_graph(), {.loss = 0.1, .delay_us = 30'000});
  for (const int robot : {0, 1, 2}) team.feed(robot, 0.7);
  REQUIRE(team.run_until_solved(300 * kSecond));
  const std::int64_t first = team.results().at(0).name.number;
  for (const int robot : {0, 1, 2}) team.feed(robot);
  REQUIRE(team.run_until_solved(300 * kSecond));
  REQUIRE(team.results().at(0).name.number > first);
  REQUIRE(team.results().at(0).keyframes == 40);
  REQUIRE(team.cost() == Approx(solve_distributed(small_graph()).cost).epsilon(1e-3));
}

TEST_CASE("a solution read back after a restart spares the round when nothing is new") {
  Team team(small_graph(), {});
  team.feed_all();
  REQUIRE(team.run_until_solved(100 * kSecond));
  const Solution solution = team.agent(1).solution();
  const std::int64_t round = solution.round.number;
  team.stop(1);
  team.network().restart(1);
  team.start(1);
  team.feed(1);
  team.agent(1).restore(solution);
  team.run_for(30 * kSecond);
  REQUIRE(team.agent(0).solution().round.number == round);
  REQUIRE(team.agent(1).phase() == AgentPhase::kIdle);
}

// What a log of its bus would have of the robot: all that it heard, and what it said.
struct Log {
  struct Event {
    Utime utime;
    AgentMessage message;
  };
  std::vector<Event> events;
  RoundResult result;
};

Log record(int robot) {
  Team team(small_graph(), {.loss = 0.2, .delay_us = 30'000});
  Log log;
  team.on_message = [&](int to, const AgentMessage& message, Utime now) {
    if (to == robot) log.events.push_back({now, message});
  };
  team.damage = [&](int from, const AgentMessage& message) -> std::optional<AgentMessage> {
    if (from == robot) log.events.push_back({team.now(), message});
    return std::nullopt;
  };
  team.run_for(3 * kSecond);
  team.feed_all();
  REQUIRE(team.run_until_solved(300 * kSecond));
  log.result = team.results().at(robot);
  return log;
}

TEST_CASE("from a log of what it heard and said a robot ends the rounds that it ended then") {
  for (const int robot : {0, 1}) {
    const Log log = record(robot);
    Team alone(small_graph());
    for (const int other : {0, 1, 2}) alone.stop(other);
    alone.run_for(kSecond);
    alone.start(robot);  // another run of the process, which its messages would name
    alone.feed(robot);
    DgncAgent& agent = alone.agent(robot);
    std::optional<RoundResult> last;
    for (const auto& [utime, message] : log.events) {
      if (sender_of(message) != robot) {
        agent.receive(message, utime);
      } else if (const auto* beacon = std::get_if<dpgo_beacon_t>(&message)) {
        agent.follow(*beacon);
      } else if (const auto* proposal = std::get_if<dpgo_round_t>(&message)) {
        agent.follow(*proposal, utime);
      }
      agent.tick(utime);
      while (agent.advance(utime)) {
      }
      if (auto result = agent.take_result()) last = std::move(result);
    }
    REQUIRE(last);
    REQUIRE(last->name == log.result.name);
    REQUIRE(last->owned_cost == log.result.owned_cost);
  }
}

TEST_CASE("what only one robot knows of two is left out, and said") {
  Team team(small_graph(), {.loss = 0.1, .delay_us = 30'000});
  team.feed_all();
  REQUIRE(team.agent(0).add(Loop{{0, 1, 3}, {1, 1, 5}, {}, isotropic(100.0, 100.0)}) == nullptr);
  REQUIRE(team.run_until_solved(300 * kSecond));
  const auto& warnings = team.results().at(0).warnings;
  REQUIRE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning.find("robots 0-1 are left out: robot 1 does not know them") != std::string::npos;
  }));
  REQUIRE(team.cost() == Approx(solve_distributed(small_graph()).cost).epsilon(1e-6));
}

bool warns_of(const RoundResult& result, int robot) {
  const std::string words = "robot " + std::to_string(robot) + "'s section dpgo differs";
  return std::any_of(result.warnings.begin(), result.warnings.end(),
                     [&](const std::string& warning) { return warning.find(words) != std::string::npos; });
}

TEST_CASE("robots with other options solve apart, hold nobody up, and are named") {
  const auto changed = [](auto change) {
    DgncOptions options;
    change(options);
    return options;
  };
  for (const DgncOptions& other :
       {changed([](DgncOptions& o) { o.mu_step = 1.4; }), changed([](DgncOptions& o) { o.updates = 3; }),
        changed([](DgncOptions& o) { o.barc2 = 100.0; }), changed([](DgncOptions& o) { o.tolerance = 1e-2; }),
        changed([](DgncOptions& o) { o.rounds = 7; }), changed([](DgncOptions& o) { o.look_back = 0; })}) {
    for (const int odd : {0, 1}) {
      Team team(small_graph(), {.loss = 0.3, .delay_us = 30'000}, 1, 8 * kSecond);
      team.start(odd, other);
      team.feed_all();
      REQUIRE(team.run_until_solved(100 * kSecond));
      REQUIRE(team.results().at(0).name.number == 1);
      for (const auto& [robot, result] : team.results()) {
        for (const int member : {0, 1, 2}) {
          const bool together = (robot == odd) == (member == odd);
          REQUIRE(warns_of(result, member) != together);
          REQUIRE(together == std::binary_search(result.robots.begin(), result.robots.end(), member));
        }
      }
      team.run_for(60 * kSecond);
      REQUIRE(team.results().at(0).name.number == 1);
    }
  }
}

TEST_CASE("options that only one robot works with need not be the same") {
  DgncOptions options;
  options.alignment.translation_sigma = 0.4;
  options.block.max_inner = 5;
  REQUIRE(common_hash(options) == common_hash({}));
}

}  // namespace
}  // namespace covey::pgo
