// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/link.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/core/radio/messages.h"

namespace covey::radio {
namespace {

constexpr Utime kStart = 1'000'000'000;

// What was put on air by one end is heard by the other.
Link::Output exchange(TestLink& sender, TestLink& receiver, Utime now) {
  for (const Bytes& datagram : sender.link.on_tick(now).air) receiver.link.receive(datagram, now);
  return receiver.link.on_tick(now);
}

std::vector<std::string> channels_of(const std::vector<Bytes>& air) {
  std::vector<std::string> channels;
  for (const Bytes& datagram : air) channels.emplace_back(parse_packet(datagram).packet.channel);
  return channels;
}

TEST_CASE("a small message crosses as itself, byte for byte, and is accounted for") {
  TestLink a(0, kStart);
  TestLink b(1, kStart);
  const Bytes payload = test_payload(0, -1, 300);
  a.link.on_tick(kStart);
  a.link.send("PLAIN", payload, kStart);
  const auto air = a.link.on_tick(kStart).air;
  REQUIRE(channels_of(air) == std::vector<std::string>{"PLAIN"});
  b.link.receive(air[0], kStart);
  const auto bus = b.link.on_tick(kStart).bus;
  REQUIRE(bus.size() == 1);
  REQUIRE(bus[0].channel == "PLAIN");
  REQUIRE(bus[0].payload == payload);
  REQUIRE(a.counts["sent_bytes/dpgo"] == static_cast<std::int64_t>(air[0].size()));
  REQUIRE(a.counts["sent_packets/dpgo"] == 1);
  REQUIRE(b.counts["received_bytes/dpgo"] == static_cast<std::int64_t>(air[0].size()));
}

TEST_CASE("a large message crosses in fragments and a sure one is acknowledged") {
  TestLink a(0, kStart);
  TestLink b(1, kStart);
  exchange(a, b, kStart);
  exchange(b, a, kStart);
  const Bytes large = test_payload(0, 1, 40'000);
  a.link.send("PLAIN", large, kStart);
  a.link.send("SURE", test_payload(0, 1, 50), kStart);
  const auto bus = exchange(a, b, kStart).bus;
  REQUIRE(bus.size() == 2);
  REQUIRE(bus[0].payload == large);
  REQUIRE(bus[1].channel == "SURE");
  REQUIRE(a.link.open_messages() == 2);
  exchange(b, a, kStart + 20'000);
  REQUIRE(a.link.open_messages() == 0);
}

TEST_CASE("what may not leave the robot is dropped with its reason") {
  TestLink a(0, kStart);
  a.link.on_tick(kStart);
  a.link.send("KEYFRAME", test_payload(0, 1, 50), kStart);
  a.link.send("PLAIN", test_payload(3, 1, 50), kStart);
  a.link.send("PLAIN", test_payload(0, 0, 50), kStart);
  a.link.send("PLAIN", test_payload(0, 99, 50), kStart);
  a.link.send("PLAIN", Bytes(10), kStart);
  Bytes other_type = test_payload(0, 1, 50);
  other_type[0] ^= 1;
  a.link.send("PLAIN", other_type, kStart);
  REQUIRE(a.link.on_tick(kStart).air.empty());
  REQUIRE(a.counts["dropped/OUT_KEYFRAME/channel_unknown"] == 1);
  REQUIRE(a.counts["dropped/OUT_PLAIN/from_another_robot"] == 1);
  REQUIRE(a.counts["dropped/OUT_PLAIN/to_itself"] == 1);
  REQUIRE(a.counts["dropped/OUT_PLAIN/to_impossible"] == 1);
  REQUIRE(a.counts["dropped/OUT_PLAIN/other_type"] == 2);
}

TEST_CASE("what is not for this robot, or not what it says, does not reach its bus") {
  TestLink b(1, kStart);
  b.link.on_tick(kStart);
  std::uint32_t sequence = 0;
  const auto hear = [&](const std::string& channel, const Bytes& payload) {
    b.link.receive(write_packet(sequence++, channel, payload), kStart);
    return b.link.on_tick(kStart).bus.size();
  };
  REQUIRE(hear("PLAIN", test_payload(0, 2, 50)) == 0);
  REQUIRE(hear("PLAIN", test_payload(1, -1, 50)) == 0);
  REQUIRE(hear("KEYFRAME", test_payload(0, 1, 50)) == 0);
  REQUIRE(hear("PLAIN", Bytes(20)) == 0);
  Bytes other_type = test_payload(0, 1, 50);
  other_type[0] ^= 1;
  REQUIRE(hear("PLAIN", other_type) == 0);
  REQUIRE(hear(kFragmentChannel, test_payload(0, 1, 50)) == 0);
  REQUIRE(hear(kAckChannel, test_payload(0, 1, 50)) == 0);
  REQUIRE(hear("PLAIN", test_payload(0, 1, 50)) == 1);
  --sequence;
  REQUIRE(hear("PLAIN", test_payload(0, 1, 50)) == 0);
  for (const char* reason : {"for_another_robot", "own_echo", "channel_unknown", "payload_too_short",
                             "other_type", "fragment_undecodable", "ack_undecodable", "duplicate"}) {
    INFO(reason);
    REQUIRE(b.counts[std::string("dropped/radio/") + reason] == 1);
  }
}

TEST_CASE("a message in fragments that names another sender inside is dropped") {
  TestLink b(1, kStart);
  radio_fragment_t fragment{};
  const Bytes body = write_body("SURE", test_payload(5, 1, 50));
  fragment.from = 0;
  fragment.to = 1;
  fragment.fragments = 1;
  fragment.total_bytes = fragment.n = static_cast<std::int32_t>(body.size());
  fragment.data = body;
  b.link.receive(write_packet(0, kFragmentChannel, encode(fragment)), kStart);
  REQUIRE(b.link.on_tick(kStart).bus.empty());
  REQUIRE(b.counts["dropped/radio/from_mismatch"] == 1);
}

TEST_CASE("a bridge that starts anew is understood at once, late mail of its last run is not") {
  TestLink b(1, kStart);
  TestLink old_run(0, kStart);
  old_run.link.send("SURE", test_payload(0, 1, 50, 1), kStart);
  const auto late = old_run.link.on_tick(kStart).air;
  TestLink new_run(0, kStart + kUsPerSecond);
  new_run.link.send("SURE", test_payload(0, 1, 50, 2), kStart + kUsPerSecond);
  const auto bus = exchange(new_run, b, kStart + kUsPerSecond).bus;
  REQUIRE(bus.size() == 1);
  REQUIRE(tag_of(bus[0].payload) == 2);
  for (const Bytes& datagram : late) b.link.receive(datagram, kStart + 2 * kUsPerSecond);
  REQUIRE(b.link.on_tick(kStart + 2 * kUsPerSecond).bus.empty());
  REQUIRE(b.counts["dropped/radio/epoch_stale"] == static_cast<std::int64_t>(late.size()));

  // A clock that went back: the old epoch is taken for new after a silence.
  TestLink third_run(0, kStart - kUsPerSecond);
  third_run.link.send("SURE", test_payload(0, 1, 50, 3), kStart);
  REQUIRE(exchange(third_run, b, kStart + 20 * kUsPerSecond).bus.size() == 1);
}

TEST_CASE("modules share a small budget and control goes first") {
  TestLink a(0, kStart, {.rate_bytes_per_s = 100'000.0, .burst_bytes = 2'000.0});
  a.link.on_tick(kStart);
  Utime now = kStart;
  for (int i = 0; i < 500; ++i) {
    a.link.send("PLAIN", test_payload(0, -1, 1000, static_cast<std::uint32_t>(i)), now);
    a.link.send("PLACE", test_payload(0, -1, 500, static_cast<std::uint32_t>(i)), now);
  }
  std::int64_t bytes = 0;
  for (; now <= kStart + 2 * kUsPerSecond; now += 10'000) {
    for (const Bytes& datagram : a.link.on_tick(now).air) bytes += static_cast<std::int64_t>(datagram.size());
  }
  REQUIRE(bytes >= 190'000);
  REQUIRE(bytes <= 210'000);
  REQUIRE(static_cast<double>(a.counts["sent_bytes/dpgo"]) ==
          Approx(static_cast<double>(a.counts["sent_bytes/place_recognition"])).epsilon(0.1));
}

TEST_CASE("without a rate, what is due in one moment is spread over ticks that stock receive buffers take") {
  TestLink a(0, kStart);
  a.link.on_tick(kStart - kUsPerSecond / 2);
  for (int i = 0; i < 600; ++i) a.link.send("PLAIN", test_payload(0, -1, 1000), kStart);
  std::size_t sent = 0;
  for (int tick = 0; tick < 12; ++tick) {
    const Utime now = kStart + tick * 10'000;
    const std::size_t at_once = a.link.on_tick(now).air.size() + a.link.on_tick(now).air.size();
    CHECK(at_once <= 51);
    sent += at_once;
  }
  CHECK(sent >= 590);
  CHECK(a.link.on_tick(kStart + 120'000).air.size() + sent == 600);
}

TEST_CASE("a queue that overflows loses its oldest") {
  LinkOptions options;
  options.max_queue_bytes = 10'000;
  TestLink a(0, kStart, {.rate_bytes_per_s = 1.0, .burst_bytes = 1'200.0}, options);
  for (int i = 0; i < 100; ++i) a.link.send("PLAIN", test_payload(0, -1, 1000), kStart);
  REQUIRE(a.counts["dropped/OUT_PLAIN/queue_full"] == 90);
}

TEST_CASE("a datagram's module is known from its channel, and of a fragment from itself") {
  const TreatmentTable table = test_table();
  REQUIRE(module_of("PLACE", {}, table) == Module::kPlaceRecognition);
  REQUIRE(module_of(kAckChannel, {}, table) == Module::kControl);
  REQUIRE_FALSE(module_of("KEYFRAME", {}, table));
  radio_fragment_t fragment{};
  fragment.module = static_cast<std::int8_t>(Module::kGeometricVerification);
  REQUIRE(module_of(kFragmentChannel, encode(fragment), table) == Module::kGeometricVerification);
  fragment.module = 77;
  REQUIRE(module_of(kFragmentChannel, encode(fragment), table) == Module::kControl);
}

TEST_CASE("20000 seeded mutated datagrams between two links do no harm") {
  std::mt19937_64 random(15);
  TestLink a(0, kStart);
  TestLink b(1, kStart);
  std::vector<Bytes> seen;
  Utime now = kStart;
  for (int trial = 0; trial < 20'000; ++trial) {
    now += 1000;
    if (trial % 40 == 0) {
      a.link.send("SURE", test_payload(0, -1, random() % 8000 + 50), now);
      b.link.send("SURE", test_payload(1, 0, random() % 3000 + 50), now);
    }
    for (Link* link : {&a.link, &b.link}) {
      for (const Bytes& datagram : link->on_tick(now).air) {
        if (seen.size() < 500) seen.push_back(datagram);
        (link == &a.link ? b : a).link.receive(datagram, now);
      }
    }
    if (seen.empty()) continue;
    Bytes forged = seen[random() % seen.size()];
    const auto flips = random() % 6;
    for (std::uint64_t i = 0; i < flips; ++i) {
      forged[random() % std::min<std::size_t>(forged.size(), 110)] = static_cast<std::uint8_t>(random());
    }
    if (random() % 4 == 0) forged.resize(random() % (forged.size() + 1));
    (random() % 2 == 0 ? a : b).link.receive(Bytes(forged), now);
  }
  // New runs of both still understand each other, whatever was forged in their names.
  now += 100 * kUsPerSecond;
  TestLink c(2, now);
  a.link.on_tick(now);
  c.link.send("SURE", test_payload(2, 0, 5000, 99), now);
  const auto bus = exchange(c, a, now).bus;
  REQUIRE(bus.size() == 1);
  REQUIRE(tag_of(bus[0].payload) == 99);
}

}  // namespace
}  // namespace covey::radio
