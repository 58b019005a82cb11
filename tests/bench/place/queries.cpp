// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/queries.h"

#include <algorithm>
#include <map>
#include <random>

#include "core/place/database.h"
#include "tests/bench/place/cpu_clock.h"

namespace covey::bench {
namespace {

constexpr std::size_t kQueries = 300;
constexpr std::uint64_t kKeptOfTen = 3;

}  // namespace

double query_ms(const std::vector<place::BagOfWords>& bags, double least_similarity) {
  place::PlaceDatabase database;
  for (const auto& bag : bags) database.add(bag);
  const std::size_t step = std::max<std::size_t>(1, bags.size() / kQueries);
  int queries = 0;
  std::size_t hits = 0;
  const CpuClock clock;
  for (std::size_t k = 0; k < bags.size(); k += step, ++queries)
    hits += database.query(bags[k], least_similarity).size();
  return hits > 0 ? 1e3 * clock.seconds() / queries : 0.0;  // each finds itself
}

std::vector<place::BagOfWords> many_bags(const std::vector<place::BagOfWords>& bags, int wanted) {
  std::vector<std::int32_t> words;
  for (const auto& bag : bags) words.insert(words.end(), bag.words.begin(), bag.words.end());
  std::mt19937_64 random(1);
  std::vector<place::BagOfWords> many;
  for (int k = 0; k < wanted; ++k) {
    const place::BagOfWords& pattern = bags[static_cast<std::size_t>(k) % bags.size()];
    std::map<std::int32_t, float> mixed;
    float sum = 0.0F;
    for (std::size_t i = 0; i < pattern.words.size(); ++i) {
      const bool kept = random() % 10 < kKeptOfTen;
      mixed[kept ? pattern.words[i] : words[random() % words.size()]] += pattern.weights[i];
      sum += pattern.weights[i];
    }
    place::BagOfWords bag;
    for (const auto& [word, weight] : mixed) {
      bag.words.push_back(word);
      bag.weights.push_back(weight / sum);
    }
    many.push_back(std::move(bag));
  }
  return many;
}

}  // namespace covey::bench
