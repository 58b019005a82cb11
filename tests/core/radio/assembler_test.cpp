// SPDX-License-Identifier: BSD-3-Clause
#include "core/radio/assembler.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <random>
#include <string>

namespace covey::radio {
namespace {

Bytes body_of(std::size_t bytes, int seed) {
  Bytes body(bytes);
  for (std::size_t i = 0; i < bytes; ++i)
    body[i] = static_cast<std::uint8_t>(i * 31 + static_cast<std::size_t>(seed));
  return body;
}

radio_fragment_t piece(const Bytes& body, std::int64_t message, int index, std::int64_t oldest = 0) {
  radio_fragment_t fragment{};
  fragment.oldest = oldest;
  fragment.message = message;
  fragment.fragment = index;
  fragment.total_bytes = static_cast<std::int32_t>(body.size());
  fragment.fragments = fragments_of(fragment.total_bytes);
  const auto begin = body.begin() + std::int64_t{index} * kFragmentBytes;
  fragment.data.assign(begin, begin + std::min<std::int64_t>(kFragmentBytes, body.end() - begin));
  fragment.n = static_cast<std::int32_t>(fragment.data.size());
  return fragment;
}

std::string refusal(Assembler& assembler, const radio_fragment_t& fragment) {
  const char* refused = assembler.add(fragment, 0).refused;
  return refused == nullptr ? "" : refused;
}

TEST_CASE("pieces in any order make the message, once") {
  const Bytes body = body_of(5 * kFragmentBytes + 17, 1);
  std::vector<int> order(6);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(3);
  Assembler assembler;
  for (std::int64_t message = 0; message < 50; ++message) {
    std::shuffle(order.begin(), order.end(), random);
    int completed = 0;
    for (const int index : order) {
      const auto result = assembler.add(piece(body, message, index), 0);
      REQUIRE(result.refused == nullptr);
      if (result.body) {
        ++completed;
        REQUIRE(*result.body == body);
      }
      const auto again = assembler.add(piece(body, message, index), 0);
      REQUIRE(again.refused == std::string("fragment_duplicate"));
      REQUIRE_FALSE(again.body);
    }
    REQUIRE(completed == 1);
  }
  REQUIRE(assembler.partial_bytes() == 0);
}

TEST_CASE("what has arrived is said as a run and a mask") {
  const Bytes body = body_of(10 * kFragmentBytes, 1);
  Assembler assembler;
  for (const int index : {0, 1, 3, 6}) assembler.add(piece(body, 4, index), 0);
  const auto arrived = assembler.take_arrived(10);
  REQUIRE(arrived.size() == 1);
  REQUIRE(arrived[0].message == 4);
  REQUIRE(arrived[0].below == 2);
  REQUIRE(arrived[0].mask == 0b1001);
  REQUIRE_FALSE(assembler.has_arrived());
  for (int index = 0; index < 10; ++index) assembler.add(piece(body, 4, index), 0);
  REQUIRE(assembler.take_arrived(10).at(0).below == 10);
}

TEST_CASE("fragments that contradict themselves or each other are refused") {
  const Bytes body = body_of(3 * kFragmentBytes - 100, 1);
  Assembler assembler;
  const auto with = [&](auto change) {
    radio_fragment_t fragment = piece(body, 2, 1);
    change(fragment);
    return refusal(assembler, fragment);
  };
  REQUIRE(with([](auto& f) { f.total_bytes = 0; }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.total_bytes = 0x7fffffff; }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.total_bytes = kMaxMessageBytes + 1; }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.fragments = 2; }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.fragment = 3; }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.fragment = -1; }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.oldest = -1; }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.oldest = std::numeric_limits<std::int64_t>::max(); }) == "fragment_numbers");
  REQUIRE(with([](auto& f) { f.fragment = 2; }) == "fragment_length");
  REQUIRE(with([](auto& f) { f.data.pop_back(); }) == "fragment_length");
  REQUIRE(with([](auto& f) { f.message = -5; }) == "fragment_window");
  REQUIRE(with([](auto& f) { f.message = std::numeric_limits<std::int64_t>::max(); }) == "fragment_window");
  REQUIRE(with([](auto& f) { f.message = kMessageWindow; }) == "fragment_window");
  REQUIRE(assembler.partial_bytes() == 0);

  REQUIRE(refusal(assembler, piece(body, 2, 1)).empty());
  REQUIRE(refusal(assembler, piece(body_of(4 * kFragmentBytes, 1), 2, 0)) == "fragment_inconsistent");
}

TEST_CASE("what the sender no longer repeats is forgotten, and numbers are used again beyond the window") {
  const Bytes body = body_of(100, 1);
  const Bytes two = body_of(2 * kFragmentBytes, 1);
  Assembler assembler;
  REQUIRE(assembler.add(piece(body, 3, 0), 0).body);
  REQUIRE(assembler.add(piece(two, 5, 0), 0).refused == nullptr);
  REQUIRE(assembler.partial_bytes() == two.size());
  REQUIRE(assembler.add(piece(body, 6, 0, 6), 0).body);
  REQUIRE(assembler.partial_bytes() == 0);
  REQUIRE(refusal(assembler, piece(two, 5, 1, 5)) == "fragment_stale");
  REQUIRE(assembler.add(piece(body, 3 + kMessageWindow, 0, 7), 0).body);
  REQUIRE(assembler.add(piece(body, 6 + 10 * kMessageWindow, 0, 10 * kMessageWindow), 0).body);
}

TEST_CASE("memory is bounded by dropping the message that was not touched for longest, and by time") {
  const Bytes body = body_of(300 * kFragmentBytes, 1);
  Assembler assembler;
  for (std::int64_t message = 0; message < 100; ++message) {
    REQUIRE(assembler.add(piece(body, message, 0), message).refused == nullptr);
    REQUIRE(assembler.partial_bytes() <= kMaxPartialBytes);
  }
  // An ack of a dropped message tells the truth.
  const auto arrived = assembler.take_arrived(100);
  REQUIRE(arrived.front().below == 0);
  REQUIRE(arrived.back().below == 1);
  REQUIRE(assembler.expire(kPartialTimeoutUs) == 0);
  REQUIRE(assembler.expire(2 * kPartialTimeoutUs) == 3);
  REQUIRE(assembler.partial_bytes() == 0);
}

TEST_CASE("20000 seeded random fragments never break the bounds") {
  std::mt19937_64 random(13);
  Assembler assembler;
  const Bytes small = body_of(2 * kFragmentBytes + 5, 1);
  const Bytes large = body_of(200 * kFragmentBytes, 2);
  const std::int64_t extremes[] = {0,
                                   -1,
                                   1,
                                   kMessageWindow,
                                   std::numeric_limits<std::int64_t>::max(),
                                   std::numeric_limits<std::int64_t>::min()};
  for (int trial = 0; trial < 20'000; ++trial) {
    const Bytes& body = random() % 4 == 0 ? large : small;
    const int index =
        static_cast<int>(random() % static_cast<std::uint64_t>(fragments_of(static_cast<int>(body.size()))));
    radio_fragment_t fragment = piece(body, static_cast<std::int64_t>(random() % 200), index);
    switch (random() % 12) {
      case 0:
        fragment.total_bytes = static_cast<std::int32_t>(random());
        break;
      case 1:
        fragment.fragments = static_cast<std::int32_t>(random());
        break;
      case 2:
        fragment.fragment = static_cast<std::int32_t>(random());
        break;
      case 3:
        fragment.message = extremes[random() % 6];
        break;
      case 4:
        fragment.oldest = extremes[random() % 6];
        break;
      case 5:
        fragment.data.resize(random() % 1200);
        break;
      case 6:
        fragment.n = static_cast<std::int32_t>(random());
        break;
      case 7:
        assembler.take_arrived(random() % 50);
        break;
      case 8:
        assembler.expire(static_cast<Utime>(random() % 200) * kUsPerSecond);
        break;
      default:
        break;
    }
    const auto result = assembler.add(fragment, trial);
    if (result.body) REQUIRE((result.body->size() == small.size() || result.body->size() == large.size()));
    REQUIRE(assembler.partial_bytes() <= kMaxPartialBytes);
  }
}

}  // namespace
}  // namespace covey::radio
