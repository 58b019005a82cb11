// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// An image as a bag of visual words: how much of each word of a vocabulary it has, TF-IDF weighted and of sum 1. With L1-normalised
// weights v, w the similarity of two images is (Nister and Stewenius, CVPR 2006, as in DBoW2, Galvez-Lopez and Tardos, T-RO 2012)
//
//   s(v, w) = 1 - |v - w|_1 / 2 = sum over common words of min(v_i, w_i)      in [0, 1], s(v, v) = 1, s(v, w) = s(w, v)

#include <cstdint>
#include <vector>

namespace covey::place {

// How often an image has each word that it has: with a vocabulary, its bag of words.
struct WordCounts {
  std::vector<std::int32_t> words;   // ascending
  std::vector<std::int32_t> counts;  // > 0
};

struct BagOfWords {
  std::vector<std::int32_t> words;  // ascending
  std::vector<float> weights;       // > 0, of sum 1
};

double similarity(const BagOfWords& a, const BagOfWords& b);

}  // namespace covey::place
