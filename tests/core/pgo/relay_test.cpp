// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/relay.h"

#include <catch2/catch.hpp>
#include <string>

namespace covey::pgo {
namespace {

constexpr Utime kNow = 10 * kUsPerSecond;

// What a robot knows of the others: whom each of them hears, and which of them it hears itself.
Presence presence_of(int robot, const std::map<int, std::vector<int>>& heard_by,
                     const std::vector<int>& heard_here) {
  Presence presence(robot, 5 * kUsPerSecond);
  for (const auto& [other, heard] : heard_by) {
    dpgo_beacon_t beacon{};
    beacon.from = other;
    REQUIRE(presence.take(beacon, kNow) == nullptr);
    presence.hear(other, std::binary_search(heard_here.begin(), heard_here.end(), other), kNow);
    dpgo_neighbours_t neighbours{};
    neighbours.from = other;
    neighbours.robots.assign(heard.begin(), heard.end());
    neighbours.n = static_cast<std::int32_t>(heard.size());
    REQUIRE(presence.take(neighbours, kNow) == nullptr);
  }
  return presence;
}

dpgo_advance_t update_of(int robot, int number, Utime utime = 5) {
  dpgo_advance_t update{};
  update.utime = utime;
  update.from = robot;
  update.to = -1;
  update.round = 3;
  update.number = number;
  return update;
}

dpgo_request_t request_of(int robot, int number, std::vector<int> robots) {
  dpgo_request_t request{};
  request.from = robot;
  request.round = 3;
  request.number = number;
  request.robots.assign(robots.begin(), robots.end());
  request.n = static_cast<std::int32_t>(robots.size());
  return request;
}

TEST_CASE("the robot between two passes on what one says, once, and it comes out as it went in") {
  const Presence presence = presence_of(1, {{0, {1}}, {2, {1}}}, {0, 2});
  Relay relay(1);
  const auto passed = relay.pass_on(update_of(0, 7), 0, 0, presence, kNow);
  REQUIRE(passed);
  REQUIRE(passed->hops == 1);
  dpgo_relay_t heard = *passed;
  heard.from = 1;
  const Unwrapped unwrapped = unwrap(heard);
  REQUIRE(unwrapped.refused == nullptr);
  REQUIRE(sender_of(*unwrapped.message) == 0);
  REQUIRE(std::get<dpgo_advance_t>(*unwrapped.message).number == 7);
  REQUIRE(is_of_a_round(heard));
  REQUIRE_FALSE(relay.pass_on(update_of(0, 7), 0, 0, presence, kNow));
  REQUIRE(relay.pass_on(update_of(0, 7, 6), 0, 0, presence, kNow));  // said again
}

TEST_CASE("nothing is passed on where it is heard anyway, or where nobody hears this robot") {
  Relay relay(1);
  REQUIRE_FALSE(
      relay.pass_on(update_of(0, 1), 0, 0, presence_of(1, {{0, {1, 2}}, {2, {0, 1}}}, {0, 2}), kNow));
  REQUIRE_FALSE(relay.pass_on(update_of(0, 1), 0, 0, presence_of(1, {{0, {1}}, {2, {}}}, {0, 2}), kNow));
  REQUIRE_FALSE(relay.pass_on(update_of(0, 1), 0, 0, presence_of(1, {{0, {1}}, {2, {1}}}, {0}), kNow));
  // Robot 2 hears the one that passes it on.
  REQUIRE_FALSE(
      relay.pass_on(update_of(3, 1), 0, 1, presence_of(1, {{0, {1, 2}}, {2, {0, 1}}}, {0, 2}), kNow));
}

TEST_CASE("of two robots that could pass on, the lower one does") {
  const std::map<int, std::vector<int>> ring = {{0, {1, 2}}, {1, {0, 2, 3}}, {2, {0, 1, 3}}, {3, {1, 2}}};
  const auto without = [&](int robot) {
    auto others = ring;
    others.erase(robot);
    return others;
  };
  REQUIRE(Relay(1).pass_on(update_of(0, 1), 0, 0, presence_of(1, without(1), {0, 2, 3}), kNow));
  REQUIRE_FALSE(Relay(2).pass_on(update_of(0, 1), 0, 0, presence_of(2, without(2), {0, 1, 3}), kNow));
  auto deaf = without(2);
  deaf[1] = {2, 3};  // no longer hears robot 0
  REQUIRE(Relay(2).pass_on(update_of(0, 1), 0, 0, presence_of(2, deaf, {0, 1, 3}), kNow));
}

TEST_CASE("who has passed a message on repeats it, and asks further only for what it has not") {
  const Presence presence = presence_of(1, {{0, {1}}, {2, {1}}, {3, {1}}}, {0, 2, 3});
  Relay relay(1);
  REQUIRE(relay.pass_on(update_of(0, 7), 0, 0, presence, kNow));
  const auto soon = relay.repeat(request_of(2, 7, {0, 1}), presence, 100, kNow + 50);
  REQUIRE(soon.relays.empty());  // on its way
  REQUIRE(soon.complete);
  const auto later = relay.repeat(request_of(2, 7, {0, 3}), presence, 100, kNow + 100);
  REQUIRE(later.relays.size() == 1);
  REQUIRE(later.relays[0].origin == 0);
  REQUIRE_FALSE(later.complete);
  REQUIRE_FALSE(relay.repeat(request_of(2, 8, {0}), presence, 100, kNow + 300).complete);
  for (int number = 8; number < 20; ++number) relay.pass_on(update_of(0, number), 0, 0, presence, kNow);
  REQUIRE_FALSE(relay.repeat(request_of(2, 7, {0}), presence, 100, kNow + 300).complete);  // let go
}

TEST_CASE("relays that cannot be are refused with a reason") {
  const auto relay_with = [](auto change) {
    dpgo_relay_t relay{};
    relay.from = 1;
    relay.origin = 0;
    relay.hops = 1;
    relay.message = encode_message(update_of(0, 1));
    change(relay);
    relay.n = static_cast<std::int32_t>(relay.message.size());
    const char* refused = unwrap(relay).refused;
    return std::string(refused == nullptr ? "" : refused);
  };
  REQUIRE(relay_with([](auto&) {}).empty());
  REQUIRE(relay_with([](auto& relay) { relay.hops = 0; }) == "values");
  REQUIRE(relay_with([](auto& relay) { relay.hops = 1 << 30; }) == "values");
  REQUIRE(relay_with([](auto& relay) { relay.origin = 1; }) == "values");
  REQUIRE(relay_with([](auto& relay) { relay.origin = -1; }) == "values");
  REQUIRE(relay_with([](auto& relay) { relay.origin = 2; }) == "origin_mismatch");
  REQUIRE(relay_with([](auto& relay) { relay.message.pop_back(); }) == "undecodable");
  REQUIRE(relay_with([](auto& relay) { relay.message.clear(); }) == "undecodable");
  REQUIRE(relay_with([](auto& relay) { relay.message[0] ^= 1; }) == "undecodable");
  REQUIRE(relay_with([](auto& relay) { relay.message = encode_message(relay); }) == "undecodable");
}

}  // namespace
}  // namespace covey::pgo
