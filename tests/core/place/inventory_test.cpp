// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/inventory.h"

#include <catch2/catch.hpp>
#include <random>
#include <string>

namespace covey::place {
namespace {

std::vector<RunInventory> there_and_back(const std::vector<RunInventory>& runs) {
  std::vector<RunInventory> back(runs.size());
  REQUIRE(decode_ids(encode_ids(runs), back) == nullptr);
  return back;
}

RunInventory run_of(const IdRanges& ids) { return {.robot = 0, .segment = 1, .ids = ids}; }

TEST_CASE("a run without gaps is said in a few bytes") {
  IdRanges ids;
  ids.add(0, 4999);
  const auto code = encode_ids({run_of(ids)});
  REQUIRE(code.size() <= 8);
  REQUIRE(there_and_back({run_of(ids)})[0].ids == ids);
  REQUIRE(there_and_back({}).empty());
}

TEST_CASE("seeded runs with gaps come back as they are, of very many gaps the newest") {
  std::mt19937 random(9);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<RunInventory> runs;
    for (unsigned k = 0; k < 1 + random() % 5; ++k) {
      IdRanges ids;
      const unsigned stretches = 1 + random() % 150;
      for (unsigned n = 0; n < stretches; ++n) {
        const int first = static_cast<int>(random() % 900);
        ids.add(first, first + static_cast<int>(random() % 5));
      }
      ids.add(kMostId - static_cast<int>(random() % 10));
      runs.push_back(run_of(ids));
    }
    const auto back = there_and_back(runs);
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const auto all = runs[k].ids.stretches().size();
      const bool cut = all > static_cast<std::size_t>(kMostStretches);
      REQUIRE((back[k].said_from > 0) == cut);
      for (int id = back[k].said_from; id < 950; ++id)
        REQUIRE(back[k].ids.contains(id) == runs[k].ids.contains(id));
      REQUIRE(back[k].ids.last() == runs[k].ids.last());
    }
  }
}

TEST_CASE("damaged codes of ids are refused, or say ids that can be") {
  std::mt19937 random(2);
  IdRanges ids;
  for (int k = 0; k < 40; ++k) ids.add(static_cast<int>(random() % 500));
  const auto good = encode_ids({run_of(ids), run_of(ids)});
  int read = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    auto code = good;
    for (unsigned k = 0; k < 1 + random() % 3; ++k)
      code[random() % code.size()] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) code.resize(random() % code.size());
    std::vector<RunInventory> runs(2 + random() % 2);
    const char* refused = decode_ids(code, runs);
    if (refused != nullptr) {
      REQUIRE((refused == std::string("ids") || refused == std::string("code")));
      continue;
    }
    ++read;
    for (const RunInventory& run : runs) {
      REQUIRE(run.ids.stretches().begin()->first >= 0);
      REQUIRE(run.ids.last() <= kMostId);
      REQUIRE(run.ids.stretches().size() <= static_cast<std::size_t>(kMostStretches));
    }
  }
  REQUIRE(read > 0);
}

}  // namespace
}  // namespace covey::place
