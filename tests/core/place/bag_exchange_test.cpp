// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/bag_exchange.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "core/place/lcd_messages.h"

namespace covey::place {
namespace {

constexpr int kOwner = 1;
constexpr int kReader = 0;  // looks for what it has in common with 1
constexpr int kOther = 2;   // and so does 1 with 2
constexpr std::int64_t kWords = 77;
constexpr Utime kStart = 1000 * kUsPerSecond;

KeyframeName own(int id) { return {kOwner, 5, id}; }

// What `robot` says that it has of the owner.
lcd_inventory_t says(int robot, Utime now, const IdRanges& ids, std::int64_t words = kWords,
                     bool whole = true) {
  Inventory inventory;
  inventory.whole = whole;
  if (!ids.empty()) inventory.runs.push_back({.robot = kOwner, .segment = 5, .ids = ids});
  return inventory_message(robot, now, words, inventory);
}

std::vector<int> all_due(BagExchange& exchange, Utime now, int to) {
  std::vector<int> ids;
  while (const auto due = exchange.next(now)) {
    REQUIRE(due->to == to);
    ids.push_back(due->name.id);
  }
  return ids;
}

IdRanges ids_of(int first, int last) {
  IdRanges ids;
  ids.add(first, last);
  return ids;
}

TEST_CASE("bags wait until somebody who wants them says what it has, then they go, the newest first") {
  REQUIRE(verifier_of(kOwner, kReader) == kReader);
  REQUIRE(verifier_of(kOwner, kOther) == kOwner);
  BagExchange exchange(kOwner, kWords);
  for (int id = 0; id < 3; ++id) exchange.offer(own(id));
  REQUIRE_FALSE(exchange.next(kStart));
  REQUIRE_FALSE(exchange.owes(kStart));
  REQUIRE(exchange.receive(says(kOther, kStart, {}), kStart) == nullptr);
  REQUIRE_FALSE(exchange.next(kStart));
  REQUIRE(exchange.receive(says(kReader, kStart, ids_of(1, 1)), kStart) == nullptr);
  REQUIRE(exchange.owes(kStart));
  REQUIRE(all_due(exchange, kStart, -1) == std::vector<int>{2, 0});
  exchange.offer(own(3));
  REQUIRE(all_due(exchange, kStart, -1) == std::vector<int>{3});
  REQUIRE(exchange.owes(kStart));
  REQUIRE(exchange.receive(says(kReader, kStart + 1, ids_of(0, 3)), kStart) == nullptr);
  REQUIRE_FALSE(exchange.owes(kStart));
}

TEST_CASE("what is overtaken is sent again to who lacks it, and what nobody lists, after a while") {
  BagExchange exchange(kOwner, kWords);
  Utime now = kStart;
  exchange.receive(says(kReader, now, {}), now);
  for (int id = 0; id < 10; ++id) {
    exchange.offer(own(id));
    REQUIRE(all_due(exchange, now, -1).size() == 1);
  }
  IdRanges got = ids_of(1, 4);
  exchange.receive(says(kReader, now + 1, got), now);
  REQUIRE_FALSE(exchange.next(now));  // mail may be disordered
  got.add(8);
  now += 100'000;
  exchange.receive(says(kReader, now, got), now);
  REQUIRE_FALSE(exchange.next(now));
  now += 400'000;
  exchange.receive(says(kReader, now, got), now);
  REQUIRE(all_due(exchange, now, kReader) == std::vector<int>{7, 6, 5, 0});  // 9 may still come
  int repeats = 0;
  for (int k = 1; k <= 60; ++k) {
    now += kUsPerSecond;
    exchange.receive(says(kReader, now, got), now);
    repeats += static_cast<int>(all_due(exchange, now, kReader).size());
  }
  REQUIRE(repeats >= 2 * 5);  // after 2, 4, 8, 16, 32 s
  REQUIRE(repeats <= 5 * 5);
  REQUIRE_FALSE(exchange.owes(now));
}

TEST_CASE("only so much is said that is not listed yet, and nothing to whom is not heard") {
  BagExchange exchange(kOwner, kWords);
  const ExchangeOptions options;
  exchange.receive(says(kReader, kStart, {}), kStart);
  for (int id = 0; id < 3 * options.window; ++id) exchange.offer(own(id));
  REQUIRE(static_cast<int>(all_due(exchange, kStart, -1).size()) == options.window);
  Utime now = kStart + options.silent_us + 1;
  REQUIRE_FALSE(exchange.present(kReader, now));
  REQUIRE_FALSE(exchange.next(now));
  REQUIRE(exchange.hear(kReader, now));
  REQUIRE_FALSE(exchange.hear(kReader, now));
  // Nothing of it came: all of it again, since it was long ago.
  exchange.receive(says(kReader, now, {}), now);
  REQUIRE(static_cast<int>(all_due(exchange, now, kReader).size()) == options.window);
  // One without memory is sent everything again.
  exchange.receive(says(kReader, now + 1, ids_of(0, 3 * options.window - 1)), now);
  REQUIRE_FALSE(exchange.next(now));
  exchange.receive(says(kReader, now + 2, {}), now);
  REQUIRE(exchange.next(now)->name == own(3 * options.window - 1));
}

TEST_CASE("late, foreign and cut inventories") {
  BagExchange exchange(kOwner, kWords);
  for (int id = 0; id < 200; ++id) exchange.offer(own(id));
  REQUIRE(exchange.receive(says(kReader, kStart, {}, kWords + 1), kStart) == std::string("vocabulary"));
  REQUIRE_FALSE(exchange.next(kStart));
  REQUIRE(exchange.receive(says(kReader, kStart, {}, kWords, false), kStart) == nullptr);
  REQUIRE_FALSE(exchange.next(kStart));
  IdRanges odd;
  for (int id = 1; id < 200; id += 2) odd.add(id);
  REQUIRE(exchange.receive(says(kReader, kStart + 2, odd), kStart) == nullptr);
  REQUIRE(exchange.receive(says(kReader, kStart + 1, {}), kStart) == std::string("late"));
  const auto due = all_due(exchange, kStart, -1);
  REQUIRE(due.front() == 198);
  REQUIRE(due.back() == 200 - 2 * kMostStretches + 2);  // nothing was said of those before
  REQUIRE(exchange.receive(says(kReader, kStart - 3600 * kUsPerSecond, {}), kStart) == nullptr);  // its clock
  lcd_inventory_t impossible = says(kReader, kStart + 3, odd);
  impossible.robots[0] = -4;
  REQUIRE(exchange.receive(impossible, kStart) == std::string("robot"));
  impossible.n = 1000;
  REQUIRE(exchange.receive(impossible, kStart) == std::string("size"));
}

TEST_CASE(
    "what is here is said each second, soon after a greeting and soon after a hole, of robots in range") {
  BagExchange exchange(kReader, kWords);
  Utime now = kStart;
  REQUIRE(exchange.say(now)->n == 0);
  REQUIRE_FALSE(exchange.say(now + kUsPerSecond / 2));
  now += kUsPerSecond;
  REQUIRE(exchange.say(now));
  exchange.hear(kOwner, now);
  REQUIRE(exchange.take(own(0)));
  REQUIRE_FALSE(exchange.take(own(0)));
  now += 100'000;
  auto said = exchange.say(now);
  REQUIRE(said->n == 1);
  Inventory inventory;
  REQUIRE(read_inventory(*said, inventory) == nullptr);
  REQUIRE(inventory.runs[0].ids == ids_of(0, 0));
  exchange.take(own(1));
  REQUIRE_FALSE(exchange.say(now + 200'000));
  exchange.take(own(3));
  said = exchange.say(now + 200'000);
  REQUIRE(said);
  REQUIRE(exchange.say(now + 7 * kUsPerSecond)->n == 0);
}

TEST_CASE("an inventory of a whole team fits a datagram") {
  BagExchange exchange(kReader, kWords);
  for (int robot = 1; robot < 20; ++robot) {
    exchange.hear(robot, kStart);
    for (int segment = 0; segment < 3; ++segment) {
      for (int id = 0; id < 4000; id += 1 + id % 97)
        exchange.take({robot, 1'000'000'000'000'000 + segment, id});
    }
  }
  std::set<int> listed;
  for (int k = 0; k < 20; ++k) {
    const auto said = exchange.say(kStart + k * 200'000);
    if (!said) continue;
    REQUIRE(said->getEncodedSize() < 1100);
    REQUIRE(said->whole == 0);
    listed.insert(said->robots.begin(), said->robots.end());
    exchange.hear(20 + k, kStart + k * 200'000);
  }
  REQUIRE(listed.size() == 19);
}

}  // namespace
}  // namespace covey::place
