// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/word_code.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>
#include <set>
#include <string>

namespace covey::place {
namespace {

constexpr int kWords = 10'000;
constexpr int kMost = 2000;

WordCounts some_counts(int features, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::map<int, int> found;
  for (int k = 0; k < features; ++k) ++found[static_cast<int>(random() % kWords)];
  WordCounts counts;
  for (const auto& [word, count] : found) {
    counts.words.push_back(word);
    counts.counts.push_back(count);
  }
  return counts;
}

std::string refusal(const std::vector<std::uint8_t>& code, int n, int words = kWords) {
  WordCounts counts;
  const char* reason = decode_words(code, n, words, kMost, counts);
  if (reason) REQUIRE(counts.words.empty());
  return reason ? reason : "";
}

TEST_CASE("words come back as they were, at a byte or so each") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const WordCounts counts = some_counts(500, seed);
    const auto code = encode_words(counts);
    REQUIRE(code.size() < 480);
    WordCounts back;
    REQUIRE(decode_words(code, static_cast<int>(counts.words.size()), kWords, kMost, back) == nullptr);
    REQUIRE(back.words == counts.words);
    REQUIRE(back.counts == counts.counts);
  }
}

TEST_CASE("the first and the last word, alone and often, come back too") {
  for (const WordCounts& counts : {WordCounts{{0}, {1}}, WordCounts{{kWords - 1}, {kMost}},
                                   WordCounts{{0, 1, kWords - 1}, {1, 700, 2}}}) {
    WordCounts back;
    REQUIRE(decode_words(encode_words(counts), static_cast<int>(counts.words.size()), kWords, kMost, back) ==
            nullptr);
    REQUIRE(back.words == counts.words);
    REQUIRE(back.counts == counts.counts);
  }
}

TEST_CASE("what no encoder wrote is refused, and says why") {
  const WordCounts counts = some_counts(500, 3);
  const int n = static_cast<int>(counts.words.size());
  auto code = encode_words(counts);
  REQUIRE(refusal(code, n) == "");
  for (const int bad : {-1, 0, kMost + 1}) REQUIRE(refusal(code, bad) == "size");
  REQUIRE(refusal(code, n - 50) == "code");
  REQUIRE(refusal(code, n, counts.words.back()) == "words");
  REQUIRE(refusal(encode_words({{4}, {kMost + 1}}), 1) == "counts");
  code.resize(code.size() - 2);
  REQUIRE(refusal(code, n) != "");
  code.resize(code.size() + 4);
  REQUIRE(refusal(code, n) != "");
  REQUIRE(refusal({}, 1) != "");
}

TEST_CASE("any bytes are refused or are words of the vocabulary") {
  std::mt19937_64 random(4);
  int taken = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::vector<std::uint8_t> code(random() % 40);
    for (auto& byte : code) byte = static_cast<std::uint8_t>(random());
    const int n = static_cast<int>(random() % 30);
    WordCounts counts;
    if (decode_words(code, n, kWords, kMost, counts)) continue;
    ++taken;
    REQUIRE(static_cast<int>(std::set(counts.words.begin(), counts.words.end()).size()) == n);
    REQUIRE(std::is_sorted(counts.words.begin(), counts.words.end()));
    REQUIRE(counts.words.front() >= 0);
    REQUIRE(counts.words.back() < kWords);
    int sum = 0;
    for (const int count : counts.counts) {
      REQUIRE(count > 0);
      sum += count;
    }
    REQUIRE(sum <= kMost);
  }
  REQUIRE(taken > 0);
}

}  // namespace
}  // namespace covey::place
