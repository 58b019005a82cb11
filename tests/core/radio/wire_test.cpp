// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/wire.h"

#include <catch2/catch.hpp>
#include <random>

#include "core/radio/packet.h"

namespace covey::radio {
namespace {

radio_fragment_t a_fragment() {
  radio_fragment_t fragment{};
  fragment.from = 1;
  fragment.to = 2;
  fragment.fragments = 1;
  fragment.n = fragment.total_bytes = kFragmentBytes;
  fragment.data.assign(kFragmentBytes, 9);
  return fragment;
}

radio_ack_t an_ack(int entries) {
  radio_ack_t ack{};
  ack.n = entries;
  ack.messages.assign(static_cast<std::size_t>(entries), 5);
  ack.below.assign(static_cast<std::size_t>(entries), 6);
  ack.masks.assign(static_cast<std::size_t>(entries), -1);
  return ack;
}

TEST_CASE("fragments and acks come back as they were, and fit a datagram") {
  const Bytes fragment = encode(a_fragment());
  REQUIRE(decode_fragment(fragment));
  REQUIRE(encode(*decode_fragment(fragment)) == fragment);
  REQUIRE(packet_bytes(kFragmentChannel, fragment.size()) <= kMaxDatagramBytes);
  const Bytes ack = encode(an_ack(kMaxAckEntries));
  REQUIRE(decode_ack(ack));
  REQUIRE(encode(*decode_ack(ack)) == ack);
  REQUIRE(packet_bytes(kAckChannel, ack.size()) <= kMaxDatagramBytes);
  REQUIRE(decode_ack(encode(an_ack(0))));
}

TEST_CASE("a count that lies about the length is refused before anything is allocated") {
  const Bytes good = encode(a_fragment());
  const std::size_t count_at = good.size() - kFragmentBytes - 4;
  for (const std::uint32_t n : {0x7fffffffU, 0xffffffffU, 0x80000000U, 0U, 1099U, 1101U}) {
    Bytes lie(good.begin(), good.begin() + static_cast<std::int64_t>(count_at));
    append_u32(lie, n);
    lie.insert(lie.end(), good.begin() + static_cast<std::int64_t>(count_at) + 4, good.end());
    REQUIRE_FALSE(decode_fragment(lie));
  }
  Bytes longer = good;
  longer.push_back(0);
  REQUIRE_FALSE(decode_fragment(longer));
  REQUIRE_FALSE(decode_fragment(ByteView(good).first(good.size() - 1)));
  REQUIRE_FALSE(decode_ack(encode(an_ack(kMaxAckEntries + 1))));
  REQUIRE_FALSE(decode_ack(good));
}

TEST_CASE("20000 mutated fragments and acks are decoded or refused") {
  std::mt19937_64 random(12);
  const Bytes seeds[] = {encode(a_fragment()), encode(an_ack(7))};
  for (int trial = 0; trial < 20'000; ++trial) {
    const Bytes& seed = seeds[random() % 2];
    Bytes bytes = seed;
    const auto flips = 1 + random() % 8;
    for (std::uint64_t i = 0; i < flips; ++i) {
      bytes[random() % std::min<std::size_t>(bytes.size(), 80)] = static_cast<std::uint8_t>(random());
    }
    if (random() % 2 == 0) bytes.resize(random() % (bytes.size() + 1));
    const Bytes exact(bytes);
    if (const auto fragment = decode_fragment(exact)) REQUIRE(encode(*fragment) == exact);
    if (const auto ack = decode_ack(exact)) REQUIRE(encode(*ack) == exact);
  }
}

}  // namespace
}  // namespace covey::radio
