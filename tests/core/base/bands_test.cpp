// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/bands.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <numeric>
#include <random>

namespace covey {
namespace {

Bytes message_of(std::size_t size, std::uint8_t seed) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), seed);
  return bytes;
}

TEST_CASE("A message comes back whole from its bands, in any order") {
  std::mt19937 random(7);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{60'000}, std::size_t{60'001}, std::size_t{721'940}}) {
    std::vector<band_t> bands = split_bands(message_of(size, 3), 1000, 5, 0);
    CHECK(bands.size() == std::max<std::size_t>(1, (size + 59'999) / 60'000));
    std::shuffle(bands.begin(), bands.end(), random);
    BandAssembler assembler;
    for (std::size_t i = 0; i < bands.size(); ++i) {
      const auto result = assembler.add(bands[i]);
      CHECK(result.dropped.empty());
      CHECK(result.message.has_value() == (i + 1 == bands.size()));
      if (result.message) CHECK(*result.message == message_of(size, 3));
    }
  }
}

TEST_CASE("An image set that lost a band is given up and counted, and so is one that is wholly missing") {
  BandAssembler assembler;
  auto first = split_bands(message_of(150'000, 1), 1000, 5, 0);
  assembler.add(first[0]);
  assembler.add(first[2]);
  BandAssembler::Result last;
  for (const band_t& band : split_bands(message_of(150'000, 2), 3000, 5, 2)) last = assembler.add(band);
  REQUIRE(last.message);
  CHECK(last.incomplete == 1);
  CHECK(last.missing == 1);
  CHECK(assembler.add(first[1]).dropped == "old");
}

TEST_CASE("Doubled bands, impossible ones and those of an earlier run are refused by name") {
  BandAssembler assembler;
  auto bands = split_bands(message_of(150'000, 1), 1000, 5, 0);
  assembler.add(bands[0]);
  CHECK(assembler.add(bands[0]).dropped == "duplicate");
  band_t impossible = bands[1];
  impossible.band = 7;
  CHECK(assembler.add(impossible).dropped == "impossible");
  impossible = bands[1];
  impossible.total_bytes = 2'000'000'000;
  CHECK(assembler.add(impossible).dropped == "impossible");
  impossible = bands[1];
  impossible.total_bytes = std::numeric_limits<std::int32_t>::max();
  CHECK(assembler.add(impossible).dropped == "impossible");
  impossible = split_bands(message_of(10, 1), 1000, 5, std::numeric_limits<std::int32_t>::max())[0];
  CHECK(assembler.add(impossible).dropped == "impossible");  // no number would follow it
  const auto earlier = split_bands(message_of(10, 1), 1000, 4, 0);
  CHECK(assembler.add(earlier[0]).dropped == "old");
}

TEST_CASE("A new run of the sender begins anew") {
  BandAssembler assembler;
  for (const band_t& band : split_bands(message_of(10, 1), 1000, 5, 90)) CHECK(assembler.add(band).message);
  for (const band_t& band : split_bands(message_of(10, 1), 1000, 6, 0)) CHECK(assembler.add(band).message);
}

TEST_CASE("Only a few incomplete image sets are kept") {
  BandAssembler assembler;
  int given_up = 0;
  for (int number = 0; number < 20; ++number) {
    given_up += assembler.add(split_bands(message_of(150'000, 1), 1000, 5, number)[0]).incomplete;
  }
  CHECK(given_up == 17);
}

}  // namespace
}  // namespace covey
