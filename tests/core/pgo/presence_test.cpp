// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/presence.h"

#include <catch2/catch.hpp>
#include <string>

namespace covey::pgo {
namespace {

constexpr Utime kSecond = kUsPerSecond;

dpgo_beacon_t beacon_of(int robot, Utime utime, Utime start_utime = 1) {
  dpgo_beacon_t beacon{};
  beacon.from = robot;
  beacon.utime = utime;
  beacon.start_utime = start_utime;
  return beacon;
}

dpgo_neighbours_t neighbours_of(int robot, Utime utime, std::vector<int> robots) {
  dpgo_neighbours_t neighbours{};
  neighbours.from = robot;
  neighbours.utime = utime;
  neighbours.robots.assign(robots.begin(), robots.end());
  neighbours.n = static_cast<std::int32_t>(robots.size());
  return neighbours;
}

TEST_CASE("a robot is a neighbour while it is heard directly, and present while it is heard at all") {
  Presence presence(0, 4 * kSecond);
  REQUIRE(presence.take(beacon_of(1, 0), 0) == nullptr);
  presence.hear(1, true, 0);
  presence.hear(1, false, 1 * kSecond);
  REQUIRE(presence.neighbours(kSecond) == std::vector<int>{1});
  REQUIRE(presence.neighbours(2 * kSecond).empty());
  REQUIRE(presence.present(1, 4 * kSecond));
  REQUIRE_FALSE(presence.present(1, 5 * kSecond));
  REQUIRE(presence.present(0, 0));
  REQUIRE_FALSE(presence.present(2, 0));
}

TEST_CASE("what a robot says of its neighbours holds until it says otherwise or falls silent") {
  Presence presence(0, 4 * kSecond);
  REQUIRE(presence.take(neighbours_of(1, 0, {2}), 0) == std::string("unknown_sender"));
  REQUIRE(presence.take(beacon_of(1, 0), 0) == nullptr);
  REQUIRE(presence.take(neighbours_of(1, 10, {2, 5}), 0) == nullptr);
  REQUIRE(presence.hears(1, 5, 0));
  REQUIRE_FALSE(presence.hears(1, 3, 0));
  REQUIRE_FALSE(presence.hears(1, 5, 4 * kSecond));
  REQUIRE(presence.take(neighbours_of(1, 9, {3}), 0) == std::string("late"));
  REQUIRE(presence.take(neighbours_of(1, 11, {3}), 0) == nullptr);
  REQUIRE_FALSE(presence.hears(1, 5, 0));
  for (const auto& robots : {std::vector{3, 3}, std::vector{5, 2}, std::vector{-1}, std::vector{64}}) {
    REQUIRE(presence.take(neighbours_of(1, 12, robots), 0) == std::string("values"));
  }
}

TEST_CASE("beacons that overtake each other, of robots that were restarted, and of robots that cannot be") {
  Presence presence(0, 4 * kSecond);
  REQUIRE(presence.take(beacon_of(1, 2 * kSecond), 0) == nullptr);
  REQUIRE(presence.take(beacon_of(1, 1 * kSecond), 0) == std::string("late"));
  REQUIRE(presence.take(beacon_of(1, 1 * kSecond, 2), 0) == nullptr);  // another run
  REQUIRE(presence.take(beacon_of(1, 100 * kSecond, 2), 0) == nullptr);
  REQUIRE(presence.take(beacon_of(1, 50 * kSecond, 2), 0) == nullptr);  // its clock was set back
  REQUIRE(presence.take(beacon_of(64, 0), 0) == std::string("values"));
  REQUIRE(presence.take(beacon_of(-1, 0), 0) == std::string("values"));
  REQUIRE(presence.take(beacon_of(1, -1), 0) == std::string("values"));
}

TEST_CASE("a clock that is set back makes nobody present for longer") {
  Presence presence(0, 4 * kSecond);
  REQUIRE(presence.take(beacon_of(1, 0), 100 * kSecond) == nullptr);
  presence.hear(1, true, 100 * kSecond);
  presence.follow_clock_back(10 * kSecond);
  REQUIRE(presence.present(1, 13 * kSecond));
  REQUIRE_FALSE(presence.present(1, 14 * kSecond));
}

}  // namespace
}  // namespace covey::pgo
