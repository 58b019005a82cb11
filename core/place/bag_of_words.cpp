// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/bag_of_words.h"

#include <algorithm>

namespace covey::place {

double similarity(const BagOfWords& a, const BagOfWords& b) {
  double sum = 0.0;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.words.size() && j < b.words.size()) {
    if (a.words[i] < b.words[j]) {
      ++i;
    } else if (b.words[j] < a.words[i]) {
      ++j;
    } else {
      sum += static_cast<double>(std::min(a.weights[i++], b.weights[j++]));
    }
  }
  return sum;
}

}  // namespace covey::place
