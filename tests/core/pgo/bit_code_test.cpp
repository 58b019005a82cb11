// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/bit_code.h"

#include <catch2/catch.hpp>
#include <random>

namespace covey::pgo {
namespace {

TEST_CASE("numbers come back as they were put, the largest too") {
  std::mt19937 random(1);
  for (int k = 0; k <= kLargestRice; ++k) {
    std::vector<std::int32_t> numbers{0, 1, -1, kLargestCoded, -kLargestCoded};
    for (int i = 0; i < 100; ++i) numbers.push_back(static_cast<std::int32_t>(random() % 2001) - 1000);
    BitWriter writer;
    writer.put(5, 3);
    for (const std::int32_t number : numbers) writer.put_rice(number, k);
    BitReader reader(writer.bytes());
    REQUIRE(reader.get(3) == 5);
    for (const std::int32_t number : numbers) REQUIRE(reader.get_rice(k) == number);
    REQUIRE(reader.ended_well());
  }
}

TEST_CASE("small numbers take few bits with the parameter that suits them") {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, 20.0);
  std::vector<std::int32_t> numbers;
  for (int i = 0; i < 1000; ++i) numbers.push_back(static_cast<std::int32_t>(std::lround(normal(random))));
  BitWriter writer;
  for (const std::int32_t number : numbers) writer.put_rice(number, best_rice(numbers));
  // The entropy of such numbers is log2(20 sqrt(2 pi e)) = 6.4 bits.
  REQUIRE(writer.bytes().size() * 8 < 6800);
}

TEST_CASE("a code that is too short, too long or holds what is never written did not end well") {
  BitWriter writer;
  writer.put_rice(3, 1);
  writer.put_rice(-9, 1);
  const auto ended_well = [](const std::vector<std::uint8_t>& bytes) {
    BitReader reader(bytes);
    reader.get_rice(1);
    reader.get_rice(1);
    return reader.ended_well();
  };
  std::vector<std::uint8_t> bytes = writer.bytes();
  REQUIRE(ended_well(bytes));
  bytes.push_back(0);
  REQUIRE_FALSE(ended_well(bytes));
  REQUIRE_FALSE(ended_well({}));
  REQUIRE_FALSE(ended_well(std::vector<std::uint8_t>(12, 0xff)));
}

}  // namespace
}  // namespace covey::pgo
