// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Bags of words by number, and an inverted index (word -> who has it) that finds the similar ones without looking at the others.

#include <vector>

#include "core/place/bag_of_words.h"

namespace covey::place {

class PlaceDatabase {
 public:
  struct Hit {
    int entry = 0;
    double similarity = 0.0;
  };

  // Entries count from 0.
  int add(BagOfWords bag);
  int size() const { return static_cast<int>(bags_.size()); }
  const BagOfWords& bag(int entry) const { return bags_[static_cast<std::size_t>(entry)]; }

  // Those with at least this similarity (and some common word), the most similar first, equal ones by number.
  std::vector<Hit> query(const BagOfWords& bag, double least_similarity) const;

 private:
  struct Posting {
    int entry;
    float weight;
  };
  std::vector<BagOfWords> bags_;
  std::vector<std::vector<Posting>> index_;  // by word
};

}  // namespace covey::place
