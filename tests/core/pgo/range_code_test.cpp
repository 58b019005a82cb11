// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/range_code.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace covey::pgo {
namespace {

std::vector<std::uint8_t> written(const std::vector<std::int32_t>& numbers) {
  RangeWriter writer;
  NumberModel model;
  for (const std::int32_t number : numbers) writer.put(number, model);
  return writer.finish();
}

std::vector<std::int32_t> normal_numbers(int count, double sigma) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0.0, sigma);
  std::vector<std::int32_t> numbers;
  for (int i = 0; i < count; ++i) numbers.push_back(static_cast<std::int32_t>(std::lround(normal(random))));
  return numbers;
}

TEST_CASE("numbers come back as they were put, the largest too") {
  for (const double sigma : {0.0, 0.1, 3.0, 1e4}) {
    std::vector<std::int32_t> numbers = normal_numbers(2000, sigma);
    numbers.insert(numbers.end(), {0, 1, -1, kLargestCoded, -kLargestCoded});
    const std::vector<std::uint8_t> code = written(numbers);
    RangeReader reader(code);
    NumberModel model;
    for (const std::int32_t number : numbers) REQUIRE(reader.get(model) == number);
    REQUIRE(reader.ended_well());
  }
}

TEST_CASE("a carry goes through all bytes that stand before it") {
  // A bit that its model hardly expects raises the low end by nearly all there is.
  for (int zeros = 0; zeros < 300; ++zeros) {
    RangeWriter writer;
    BitModel model;
    BitModel other;
    for (int k = 0; k < zeros; ++k) writer.put(false, model);
    writer.put(true, model);
    for (int k = 0; k < 50; ++k) writer.put(true, other);
    const std::vector<std::uint8_t> code = writer.finish();
    RangeReader reader(code);
    BitModel read;
    BitModel read_other;
    for (int k = 0; k < zeros; ++k) REQUIRE_FALSE(reader.get(read));
    REQUIRE(reader.get(read));
    for (int k = 0; k < 50; ++k) REQUIRE(reader.get(read_other));
    REQUIRE(reader.ended_well());
  }
}

TEST_CASE("numbers take about as many bits as their entropy, zeros next to none") {
  // Of normal deviates it is log2(sigma sqrt(2 pi e)).
  for (const double sigma : {2.0, 20.0}) {
    const double entropy = std::log2(sigma * std::sqrt(2.0 * M_PI * std::exp(1.0)));
    REQUIRE(static_cast<double>(written(normal_numbers(4000, sigma)).size()) * 8.0 <
            4000.0 * (entropy + 0.2));
  }
  REQUIRE(written(std::vector<std::int32_t>(4000, 0)).size() < 20);
}

TEST_CASE("a code that is too short or too long did not end well") {
  const std::vector<std::int32_t> numbers = normal_numbers(10, 50.0);
  const auto ended_well = [&](const std::vector<std::uint8_t>& bytes) {
    RangeReader reader(bytes);
    NumberModel model;
    for (std::size_t k = 0; k < numbers.size(); ++k) reader.get(model);
    return reader.ended_well();
  };
  std::vector<std::uint8_t> bytes = written(numbers);
  REQUIRE(ended_well(bytes));
  bytes.push_back(0);
  REQUIRE_FALSE(ended_well(bytes));
  bytes.resize(bytes.size() - 3);
  REQUIRE_FALSE(ended_well(bytes));
  REQUIRE_FALSE(ended_well({}));
}

}  // namespace
}  // namespace covey::pgo
