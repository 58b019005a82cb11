// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/descriptor_matcher.h"

#include <catch2/catch.hpp>
#include <random>

namespace covey::place {
namespace {

Descriptor random_descriptor(std::mt19937_64& random) { return {random(), random(), random(), random()}; }

Descriptor flipped(Descriptor descriptor, int bits, int from) {
  for (int bit = from; bit < from + bits; ++bit) descriptor[bit / 64] ^= std::uint64_t{1} << (bit % 64);
  return descriptor;
}

TEST_CASE("each point finds its own among others, whichever side has more") {
  std::mt19937_64 random(1);
  std::vector<Descriptor> a;
  std::vector<Descriptor> b;
  for (int k = 0; k < 30; ++k) a.push_back(random_descriptor(random));
  for (int k = 0; k < 50; ++k) b.push_back(random_descriptor(random));
  std::vector<std::pair<int, int>> expected;
  for (int k = 0; k < 30; k += 2) {
    b[static_cast<std::size_t>(49 - k)] = flipped(a[static_cast<std::size_t>(k)], k, 7 * k);
    expected.emplace_back(k, 49 - k);
  }
  REQUIRE(match_descriptors(a, b) == expected);
  std::vector<std::pair<int, int>> turned;
  for (const auto& [in_a, in_b] : expected) turned.emplace_back(in_b, in_a);
  std::sort(turned.begin(), turned.end());
  REQUIRE(match_descriptors(b, a) == turned);
}

TEST_CASE("what is far, doubtful or nearer to another has no match") {
  std::mt19937_64 random(2);
  const Descriptor x = random_descriptor(random);
  const Descriptor y = random_descriptor(random);
  const auto none = std::vector<std::pair<int, int>>{};
  const auto only = std::vector<std::pair<int, int>>{{0, 0}};
  REQUIRE(match_descriptors({x, y}, {flipped(x, 64, 0), random_descriptor(random)}) == only);
  REQUIRE(match_descriptors({x, y}, {flipped(x, 65, 0), random_descriptor(random)}) == none);
  REQUIRE(match_descriptors({x, y}, {flipped(x, 40, 0), flipped(x, 50, 100)}) == only);  // 0.8 as far
  REQUIRE(match_descriptors({x, y}, {flipped(x, 41, 0), flipped(x, 50, 100)}) == none);
  REQUIRE(match_descriptors({x, flipped(x, 9, 0)}, {flipped(x, 10, 0), y}) ==
          std::vector<std::pair<int, int>>{{1, 0}});
  REQUIRE(match_descriptors({x}, {x, y}) == none);  // nothing to compare with
}

}  // namespace
}  // namespace covey::place
