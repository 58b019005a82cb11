// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/id_ranges.h"

#include <catch2/catch.hpp>
#include <random>
#include <set>

namespace covey::place {
namespace {

TEST_CASE("stretches grow together, whatever order their numbers come in") {
  IdRanges ids;
  REQUIRE(ids.empty());
  REQUIRE(ids.add(5));
  REQUIRE_FALSE(ids.add(5));
  REQUIRE(ids.add(7));
  REQUIRE(ids.stretches().size() == 2);
  REQUIRE(ids.add(6));
  REQUIRE(ids.stretches() == std::map<int, int>{{5, 7}});
  REQUIRE(ids.add(0, 2));
  REQUIRE(ids.add(1, 4));
  REQUIRE_FALSE(ids.add(2, 6));
  REQUIRE(ids.stretches() == std::map<int, int>{{0, 7}});
  REQUIRE(ids.last() == 7);
}

TEST_CASE("seeded numbers are there when they were added, and stretches do not touch") {
  std::mt19937 random(4);
  for (int trial = 0; trial < 50; ++trial) {
    IdRanges ids;
    std::set<int> all;
    for (int k = 0; k < 60; ++k) {
      const int first = static_cast<int>(random() % 100);
      const int last = first + static_cast<int>(random() % 4);
      const std::size_t before = all.size();
      for (int id = first; id <= last; ++id) all.insert(id);
      REQUIRE(ids.add(first, last) == (all.size() > before));
    }
    for (int id = -1; id < 110; ++id) REQUIRE(ids.contains(id) == all.contains(id));
    int before = -2;
    for (const auto& [first, last] : ids.stretches()) {
      REQUIRE(first > before + 1);
      REQUIRE(last >= first);
      before = last;
    }
  }
}

}  // namespace
}  // namespace covey::place
