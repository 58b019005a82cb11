// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/reliable.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "core/radio/addressing.h"

namespace covey::radio {
namespace {

constexpr Utime kEpoch = 1'000'000'000;
constexpr Module kModule = Module::kDpgo;

struct Bench {
  ReliableSender sender{0, kEpoch, {}};
  Utime now = kEpoch;
  std::int64_t acks = 0;

  std::vector<radio_fragment_t> drain() {
    std::vector<radio_fragment_t> sent;
    while (auto fragment = sender.next(kModule, now)) sent.push_back(*fragment);
    return sent;
  }
  // Says that `robot` has fragments 0 ... below - 1 and those of the mask.
  const char* ack(int robot, std::int64_t message, int below, std::int64_t mask = 0) {
    sender.on_heard(robot, now);
    radio_ack_t ack{};
    ack.from = robot;
    ack.number = acks++;
    ack.sender_epoch = kEpoch;
    ack.heard_utime = now - 1000;
    ack.n = 1;
    ack.messages = {message};
    ack.below = {below};
    ack.masks = {mask};
    return sender.on_ack(ack, now);
  }
  // Time passes, and these robots give signs of life.
  void pass(Utime duration, const std::vector<int>& alive) {
    const Utime end = now + duration;
    while (now < end) {
      now += std::min<Utime>(kUsPerSecond, end - now);
      for (const int robot : alive) sender.on_heard(robot, now);
      sender.on_tick(now);
    }
  }
};

TEST_CASE("a message to one robot is repeated until it is acknowledged, at growing distances") {
  Bench bench;
  bench.sender.on_heard(1, bench.now);
  REQUIRE(bench.sender.submit(kModule, 0, 1, Bytes(3000), bench.now) == nullptr);
  REQUIRE(bench.drain().size() == 3);
  REQUIRE(bench.drain().empty());
  REQUIRE(bench.ack(1, 0, 1, 0b1) == nullptr);  // 0 and 2
  std::vector<Utime> repeats;
  const Utime begin = bench.now;
  while (bench.now < begin + 30 * kUsPerSecond) {
    bench.now += 10'000;
    bench.sender.on_heard(1, bench.now);
    for (const auto& fragment : bench.drain()) {
      REQUIRE(fragment.fragment == 1);
      REQUIRE(fragment.to == 1);
      repeats.push_back(bench.now - begin);
    }
  }
  REQUIRE(repeats.size() > 4);
  REQUIRE(repeats.size() < 14);
  REQUIRE(repeats.back() - repeats[repeats.size() - 2] > 2 * (repeats[1] - repeats[0]));
  bench.ack(1, 0, 3);
  REQUIRE(bench.drain().empty());
  REQUIRE(bench.sender.open_messages() == 0);
  REQUIRE(bench.sender.open_bytes() == 0);
}

TEST_CASE(
    "a message to everyone is sent once, repaired to the one that misses it, repeated when several do") {
  Bench bench;
  for (const int robot : {1, 2, 3}) bench.sender.on_heard(robot, bench.now);
  bench.sender.submit(kModule, 0, kToEveryone, Bytes(2000), bench.now);
  for (const auto& fragment : bench.drain()) REQUIRE(fragment.to == kToEveryone);
  bench.ack(1, 0, 2);
  bench.ack(2, 0, 1);
  bench.ack(3, 0, 0, 0b1);
  bench.now += 400'000;
  auto repeats = bench.drain();
  REQUIRE(repeats.size() == 2);
  REQUIRE((repeats[0].fragment == 0 && repeats[0].to == 3));
  REQUIRE((repeats[1].fragment == 1 && repeats[1].to == 2));

  bench.sender.submit(kModule, 0, kToEveryone, Bytes(100), bench.now);
  REQUIRE(bench.drain().size() == 1);
  bench.ack(1, 1, 1);
  bench.now += 400'000;
  repeats = bench.drain();
  REQUIRE(std::any_of(repeats.begin(), repeats.end(), [](const auto& fragment) {
    return fragment.message == 1 && fragment.to == kToEveryone;
  }));
}

TEST_CASE("robots that turn up while a message lingers get it, afterwards it is closed") {
  Bench bench;
  bench.sender.submit(kModule, 0, kToEveryone, Bytes(100), bench.now);
  REQUIRE(bench.drain().size() == 1);
  bench.pass(kUsPerSecond, {});
  bench.sender.on_heard(4, bench.now);
  bench.now += 400'000;
  const auto repeats = bench.drain();
  REQUIRE(repeats.size() == 1);
  REQUIRE(repeats[0].to == 4);
  bench.ack(4, 0, 1);
  bench.pass(2 * kUsPerSecond, {4});
  REQUIRE(bench.drain().empty());
  REQUIRE(bench.sender.open_messages() == 0);
}

TEST_CASE("nothing is repeated to a silent robot, it is given up when long gone, and that is counted") {
  Bench bench;
  bench.ack(1, 0, 0);
  bench.sender.on_heard(1, bench.now);
  bench.sender.submit(kModule, 0, kToEveryone, Bytes(100), bench.now);
  bench.ack(1, 0, 0);
  bench.drain();
  bench.pass(6 * kUsPerSecond, {});
  REQUIRE(bench.drain().empty());
  bench.pass(20 * kUsPerSecond, {});
  REQUIRE(bench.drain().empty());
  bench.sender.on_heard(1, bench.now);
  REQUIRE(bench.drain().size() == 1);
  int missed = 0;
  for (int s = 0; s < 62; ++s) {
    bench.now += kUsPerSecond;
    missed += bench.sender.on_tick(bench.now);
  }
  REQUIRE(missed == 1);
  bench.drain();
  REQUIRE(bench.sender.open_messages() == 0);
}

TEST_CASE("what was never sent to a robot that is given up stays unsent") {
  Bench bench;
  REQUIRE(bench.sender.submit(kModule, 0, 1, Bytes(200 * kFragmentBytes), bench.now) == nullptr);
  REQUIRE(bench.drain().size() == kFragmentWindow);
  bench.pass(2 * 60 * kUsPerSecond, {});
  REQUIRE(bench.drain().empty());
  REQUIRE(bench.sender.open_messages() == 0);
}

TEST_CASE("an invented robot that talks but never acknowledges does not hold messages for ever") {
  Bench bench;
  for (int robot = 1; robot < kMaxRobots; ++robot) bench.sender.on_heard(robot, bench.now);
  bench.sender.submit(kModule, 0, kToEveryone, Bytes(100), bench.now);
  std::vector<int> everyone;
  for (int robot = 1; robot < kMaxRobots; ++robot) everyone.push_back(robot);
  bench.pass(62 * kUsPerSecond, everyone);
  bench.drain();
  REQUIRE(bench.sender.open_messages() == 0);
}

TEST_CASE("a restarted robot is sent again what it had not finished") {
  Bench bench;
  bench.sender.on_heard(1, bench.now);
  bench.sender.submit(kModule, 0, 1, Bytes(3000), bench.now);
  bench.drain();
  bench.ack(1, 0, 2);
  bench.sender.on_restart(1, bench.now);
  bench.now += kUsPerSecond;
  bench.sender.on_heard(1, bench.now);
  REQUIRE(bench.drain().size() == 3);
}

TEST_CASE("the newest ack is the truth, an older one changes nothing, a wrong one is refused") {
  Bench bench;
  bench.sender.on_heard(1, bench.now);
  bench.sender.submit(kModule, 0, 1, Bytes(3000), bench.now);
  bench.drain();
  bench.ack(1, 0, 2);
  bench.acks = 0;
  REQUIRE(bench.ack(1, 0, 0) == nullptr);
  bench.now += 400'000;
  REQUIRE(bench.drain().size() == 1);
  REQUIRE(bench.ack(1, 7, 0) == std::string("ack_numbers"));
  REQUIRE(bench.ack(1, -1, 0) == std::string("ack_numbers"));
  REQUIRE(bench.ack(1, 0, 4) == std::string("ack_numbers"));
  REQUIRE(bench.ack(1, 0, -1) == std::string("ack_numbers"));
  radio_ack_t other{};
  other.sender_epoch = kEpoch - 1;
  REQUIRE(bench.sender.on_ack(other, bench.now) == std::string("ack_stale"));
}

TEST_CASE("the higher priority and then the older goes first, what is too much is refused") {
  Bench bench;
  bench.sender.submit(kModule, 0, 1, Bytes(10), bench.now);
  bench.sender.submit(kModule, 5, 1, Bytes(10), bench.now);
  bench.sender.submit(kModule, 5, 1, Bytes(10), bench.now);
  const auto sent = bench.drain();
  REQUIRE(sent.size() == 3);
  REQUIRE((sent[0].message == 1 && sent[1].message == 2 && sent[2].message == 0));
  REQUIRE(bench.sender.submit(kModule, 0, 1, Bytes(kMaxMessageBytes + 1), 0) ==
          std::string("message_too_long"));
  const char* refused = nullptr;
  for (int i = 0; i < 100 && refused == nullptr; ++i) {
    refused = bench.sender.submit(kModule, 0, 1, Bytes(kMaxMessageBytes), bench.now);
  }
  REQUIRE(refused == std::string("queue_full"));
  REQUIRE(bench.sender.open_bytes() <= ReliableOptions{}.max_bytes);
}

TEST_CASE("20000 seeded acks that lie leave the sender whole") {
  std::mt19937_64 random(14);
  Bench bench;
  for (const int robot : {1, 2, 3}) bench.sender.on_heard(robot, bench.now);
  int taken = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    if (trial % 250 == 0)
      bench.sender.submit(kModule, 0, trial % 500 == 0 ? -1 : 2, Bytes(random() % 9000 + 1), bench.now);
    bench.now += static_cast<Utime>(random() % 20'000);
    bench.drain();
    radio_ack_t ack{};
    ack.from = static_cast<int>(random() % kMaxRobots);
    ack.number = static_cast<std::int64_t>(random());
    ack.sender_epoch = random() % 8 == 0 ? static_cast<std::int64_t>(random()) : kEpoch;
    ack.heard_utime = random() % 2 == 0 ? static_cast<std::int64_t>(random()) : bench.now - 5;
    ack.held_us = random() % 2 == 0 ? static_cast<std::int64_t>(random()) : 5;
    ack.n = static_cast<std::int32_t>(random() % 5);
    for (int i = 0; i < ack.n; ++i) {
      ack.messages.push_back(random() % 4 == 0 ? static_cast<std::int64_t>(random())
                                               : static_cast<std::int64_t>(random() % 100));
      ack.below.push_back(random() % 4 == 0 ? static_cast<std::int32_t>(random())
                                            : static_cast<std::int32_t>(random() % 9));
      ack.masks.push_back(static_cast<std::int64_t>(random()));
    }
    if (random() % 8 == 0) bench.sender.on_heard(ack.from, bench.now);
    if (random() % 500 == 0) bench.sender.on_restart(ack.from, bench.now);
    taken += bench.sender.on_ack(ack, bench.now) == nullptr ? 1 : 0;
    if (trial % 100 == 0) bench.sender.on_tick(bench.now);
  }
  REQUIRE(taken > 100);
  bench.pass(200 * kUsPerSecond, {});
  bench.drain();
  REQUIRE(bench.sender.open_messages() == 0);
  REQUIRE(bench.sender.open_bytes() == 0);
}

}  // namespace
}  // namespace covey::radio
