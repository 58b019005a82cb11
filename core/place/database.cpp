// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/database.h"

#include <algorithm>
#include <utility>

namespace covey::place {

int PlaceDatabase::add(BagOfWords bag) {
  const int entry = size();
  for (std::size_t k = 0; k < bag.words.size(); ++k) {
    const auto word = static_cast<std::size_t>(bag.words[k]);
    if (word >= index_.size()) index_.resize(word + 1);
    index_[word].push_back({entry, bag.weights[k]});
  }
  bags_.push_back(std::move(bag));
  return entry;
}

std::vector<PlaceDatabase::Hit> PlaceDatabase::query(const BagOfWords& bag, double least_similarity) const {
  std::vector<double> sums(bags_.size(), 0.0);
  for (std::size_t k = 0; k < bag.words.size(); ++k) {
    const auto word = static_cast<std::size_t>(bag.words[k]);
    if (word >= index_.size()) continue;
    for (const Posting& posting : index_[word]) {
      sums[static_cast<std::size_t>(posting.entry)] +=
          static_cast<double>(std::min(bag.weights[k], posting.weight));
    }
  }
  std::vector<Hit> hits;
  for (std::size_t entry = 0; entry < sums.size(); ++entry) {
    if (sums[entry] > 0.0 && sums[entry] >= least_similarity)
      hits.push_back({static_cast<int>(entry), sums[entry]});
  }
  std::stable_sort(hits.begin(), hits.end(),
                   [](const Hit& a, const Hit& b) { return a.similarity > b.similarity; });
  return hits;
}

}  // namespace covey::place
