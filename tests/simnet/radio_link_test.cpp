// SPDX-License-Identifier: BSD-3-Clause
// The link protocol between N robots in virtual time: whatever the network does, every message that must
// arrive arrives exactly once at every robot that it is meant for and that can be reached.
#include <catch2/catch.hpp>
#include <iostream>
#include <memory>

#include "tests/core/radio/messages.h"
#include "tests/simnet/network.h"

namespace covey::radio {
namespace {

constexpr Utime kStep = 10'000;
constexpr Utime kStart = 1'000'000'000;

class Team {
 public:
  Team(int robots, std::uint64_t seed, LinkFaults faults) : network(seed, faults, robots), random_(seed + 1) {
    for (int robot = 0; robot < robots; ++robot) ends.push_back(std::make_unique<TestLink>(robot, kStart));
    arrived.resize(ends.size());
  }

  // Sends a message that must arrive (larger than one datagram now and then) and returns its tag.
  std::uint32_t say(int from, int to) {
    const std::size_t bytes = random_() % 4 == 0 ? 1200 + random_() % 20'000 : 100 + random_() % 900;
    payload_bytes += static_cast<std::int64_t>(bytes);
    ends[static_cast<std::size_t>(from)]->link.send("SURE", test_payload(from, to, bytes, ++tags_), now);
    return tags_;
  }

  void pass(Utime duration) {
    for (const Utime end = now + duration; now < end; now += kStep) {
      network.deliver_until(now, [&](int to, int, const Bytes& datagram, Utime t) {
        ends[static_cast<std::size_t>(to)]->link.receive(datagram, t);
      });
      for (std::size_t robot = 0; robot < ends.size(); ++robot) {
        const Link::Output output = ends[robot]->link.on_tick(now);
        for (const Bytes& datagram : output.air) {
          air_bytes += static_cast<std::int64_t>(datagram.size());
          network.send(static_cast<int>(robot), kEveryone, datagram, now);
        }
        for (const auto& delivery : output.bus) ++arrived[robot][tag_of(delivery.payload)];
      }
    }
  }

  void restart(int robot) {
    network.restart(robot);
    ends[static_cast<std::size_t>(robot)] = std::make_unique<TestLink>(robot, now);
  }

  std::size_t open_messages() const {
    std::size_t open = 0;
    for (const auto& end : ends) open += end->link.open_messages();
    return open;
  }

  SimNetwork<Bytes> network;
  std::vector<std::unique_ptr<TestLink>> ends;
  std::vector<std::map<std::uint32_t, int>> arrived;  // per robot: tag -> how often
  Utime now = kStart;
  std::int64_t payload_bytes = 0;
  std::int64_t air_bytes = 0;

 private:
  std::mt19937_64 random_;
  std::uint32_t tags_ = 0;
};

struct Said {
  std::uint32_t tag;
  int from;
  int to;
};

void check_exactly_once(const Team& team, const std::vector<Said>& said) {
  for (const Said& message : said) {
    for (int robot = 0; robot < static_cast<int>(team.ends.size()); ++robot) {
      const bool meant = robot != message.from && (message.to == kToEveryone || message.to == robot);
      const auto& arrived = team.arrived[static_cast<std::size_t>(robot)];
      const auto times = arrived.count(message.tag) > 0 ? arrived.at(message.tag) : 0;
      INFO("message " << message.tag << " from " << message.from << " to " << message.to << " at " << robot);
      REQUIRE(times == (meant ? 1 : 0));
    }
  }
}

// Robots in turn, two messages to everyone for one to a neighbour, over `duration`.
std::vector<Said> talk(Team& team, int messages, Utime duration) {
  std::vector<Said> said;
  const int robots = static_cast<int>(team.ends.size());
  for (int i = 0; i < messages; ++i) {
    const int from = i % robots;
    const int to = i % 3 == 2 ? (from + 1) % robots : kToEveryone;
    said.push_back({team.say(from, to), from, to});
    team.pass(duration / messages);
  }
  return said;
}

TEST_CASE("every message arrives exactly once under loss, duplication and reordering") {
  for (const int robots : {2, 5}) {
    for (const double loss : {0.0, 0.2, 0.5}) {
      Team team(robots, 7, {.loss = loss, .delay_us = 100'000, .jitter_us = 60'000, .duplicate = 0.1});
      team.pass(2 * kUsPerSecond);
      team.air_bytes = 0;
      const auto said = talk(team, 300, 20 * kUsPerSecond);
      team.pass(30 * kUsPerSecond);
      check_exactly_once(team, said);
      REQUIRE(team.open_messages() == 0);
      const double overhead = static_cast<double>(team.air_bytes) / static_cast<double>(team.payload_bytes);
      std::cout << robots << " robots, loss " << loss << ": " << overhead
                << " bytes on air per byte of message\n";
      REQUIRE(overhead < 1.35 / ((1.0 - loss) * (1.0 - loss)) * (robots > 2 ? 1.6 : 1.0));
    }
  }
}

TEST_CASE("a team that starts together misses nothing of what is said before anyone was heard") {
  Team team(4, 8, {.loss = 0.3, .delay_us = 50'000});
  std::vector<Said> said;
  for (int from = 0; from < 4; ++from) said.push_back({team.say(from, kToEveryone), from, kToEveryone});
  team.pass(30 * kUsPerSecond);
  check_exactly_once(team, said);
}

TEST_CASE("messages wait for the end of a partition, and little is sent into it") {
  Team team(4, 9, {.loss = 0.2, .delay_us = 50'000, .jitter_us = 50'000});
  team.pass(3 * kUsPerSecond);
  team.network.partition({0, 1}, {2, 3});
  auto said = talk(team, 100, 10 * kUsPerSecond);
  team.pass(10 * kUsPerSecond);
  REQUIRE(team.open_messages() > 0);
  const std::int64_t before = team.air_bytes;
  team.pass(10 * kUsPerSecond);
  REQUIRE(team.air_bytes - before < 10 * 4 * 200);  // signs of life
  team.network.heal();
  team.pass(20 * kUsPerSecond);
  check_exactly_once(team, said);
  REQUIRE(team.open_messages() == 0);
}

TEST_CASE("a robot that is gone for good is given up, the others get everything") {
  Team team(3, 10, {.loss = 0.2, .delay_us = 20'000});
  team.pass(3 * kUsPerSecond);
  team.network.isolate(2);
  std::vector<Said> said;
  for (int i = 0; i < 20; ++i) said.push_back({team.say(0, kToEveryone), 0, kToEveryone});
  team.pass(100 * kUsPerSecond);
  for (const Said& message : said) REQUIRE(team.arrived[1][message.tag] == 1);
  REQUIRE(team.ends[0]->link.open_messages() == 0);
  REQUIRE(team.ends[0]->counts["gave_up/radio"] == 20);
}

TEST_CASE("restarts of sender and receiver leave the rest of the conversation whole") {
  Team team(3, 11, {.loss = 0.3, .delay_us = 50'000, .jitter_us = 30'000, .duplicate = 0.05});
  team.pass(3 * kUsPerSecond);
  talk(team, 30, kUsPerSecond);  // interrupted
  team.restart(0);
  team.pass(kUsPerSecond);
  auto said = talk(team, 60, 5 * kUsPerSecond);
  team.pass(20 * kUsPerSecond);
  check_exactly_once(team, said);
  team.restart(1);
  team.pass(kUsPerSecond);
  said = talk(team, 60, 5 * kUsPerSecond);
  team.pass(20 * kUsPerSecond);
  check_exactly_once(team, said);
  REQUIRE(team.open_messages() == 0);
}

}  // namespace
}  // namespace covey::radio
