// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/packet.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "tests/core/radio/messages.h"

namespace covey::radio {
namespace {

Bytes raw(std::uint32_t magic, const std::string& rest) {
  Bytes datagram;
  append_u32(datagram, magic);
  append_u32(datagram, 7);
  datagram.insert(datagram.end(), rest.begin(), rest.end());
  return datagram;
}

std::string refusal(const Bytes& datagram) {
  const char* refused = parse_packet(datagram).refused;
  return refused == nullptr ? "" : refused;
}

TEST_CASE("what is written is read back") {
  const Bytes payload = test_payload(1, -1, 100);
  const Bytes datagram = write_packet(42, "DPGO_STATE", payload);
  REQUIRE(datagram.size() == packet_bytes("DPGO_STATE", payload.size()));
  const ParsedPacket parsed = parse_packet(datagram);
  REQUIRE(parsed.refused == nullptr);
  REQUIRE(parsed.packet.sequence == 42);
  REQUIRE(parsed.packet.channel == "DPGO_STATE");
  REQUIRE(Bytes(parsed.packet.payload.begin(), parsed.packet.payload.end()) == payload);
}

TEST_CASE("every wrong packet is refused with its reason") {
  const std::string zero(1, '\0');
  REQUIRE(refusal({}) == "too_short");
  REQUIRE(refusal({0x4c, 0x43, 0x30}) == "too_short");
  REQUIRE(refusal(raw(kSmallMessageMagic, std::string(1193, 'x'))) == "too_long");
  REQUIRE(refusal(raw(kFragmentMagic, std::string(542, '\xff'))) == "lcm_fragment");
  REQUIRE(refusal(raw(0x4c433031, "A" + zero)) == "magic");
  REQUIRE(refusal(raw(kSmallMessageMagic, "")) == "channel_unterminated");
  REQUIRE(refusal(raw(kSmallMessageMagic, std::string(1192, 'A'))) == "channel_unterminated");
  REQUIRE(refusal(raw(kSmallMessageMagic, zero + "payload")) == "channel_empty");
  REQUIRE(refusal(raw(kSmallMessageMagic, std::string(64, 'A') + zero)) == "channel_too_long");
  REQUIRE(refusal(raw(kSmallMessageMagic, std::string(63, 'A') + zero)).empty());
  REQUIRE(refusal(raw(kSmallMessageMagic, "A B" + zero)) == "channel_unprintable");
  REQUIRE(refusal(raw(kSmallMessageMagic, "A\xc3" + zero)) == "channel_unprintable");
}

TEST_CASE("addresses are read from the head of a payload, and impossible ones refused") {
  const Bytes payload = test_payload(3, -1, 60);
  const auto addressing = peek_addressing(payload);
  REQUIRE(addressing);
  REQUIRE(addressing->fingerprint == kTestFingerprint);
  REQUIRE(addressing->utime == 1'000'000);
  REQUIRE(addressing->from == 3);
  REQUIRE(addressing->to == kToEveryone);
  REQUIRE(refusal_of_ids(*addressing) == nullptr);
  REQUIRE_FALSE(peek_addressing(ByteView(payload).first(kAddressingBytes - 1)));
  REQUIRE(refusal_of_ids({0, 0, -1, 0}) == std::string("from_impossible"));
  REQUIRE(refusal_of_ids({0, 0, kMaxRobots, 0}) == std::string("from_impossible"));
  REQUIRE(refusal_of_ids({0, 0, 0, -2}) == std::string("to_impossible"));
}

TEST_CASE("the parser reads 20000 mutated packets without leaving them") {
  std::mt19937_64 random(11);
  const Bytes good = write_packet(1, "SURE", test_payload(1, 2, 200));
  int accepted = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    // Cut to its exact size on the heap, so that the sanitizer sees any byte read beyond it.
    Bytes datagram(good.begin(), good.begin() + static_cast<std::int64_t>(random() % (good.size() + 1)));
    const auto flips = random() % 4;
    for (std::uint64_t i = 0; i < flips && !datagram.empty(); ++i) {
      datagram[random() % std::min<std::size_t>(datagram.size(), 16)] = static_cast<std::uint8_t>(random());
    }
    const Bytes exact(datagram);
    const ParsedPacket parsed = parse_packet(exact);
    if (parsed.refused != nullptr) continue;
    ++accepted;
    REQUIRE(8 + parsed.packet.channel.size() + 1 + parsed.packet.payload.size() == exact.size());
    peek_addressing(parsed.packet.payload);
  }
  REQUIRE(accepted > 1000);
  REQUIRE(accepted < 19'000);
}

}  // namespace
}  // namespace covey::radio
