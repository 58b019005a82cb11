// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How long it takes to find the keyframes that are like one, by how many there are.

#include <vector>

#include "core/place/bag_of_words.h"

namespace covey::bench {

// ms of CPU of a query among bags themselves.
double query_ms(const std::vector<place::BagOfWords>& bags, double least_similarity);

// As many keyframes as a long run has, made from those of a short one: each is one of `bags` of which seven words of ten were replaced by words
// of others, so that words are as frequent as they were and hardly two keyframes are alike.
std::vector<place::BagOfWords> many_bags(const std::vector<place::BagOfWords>& bags, int wanted);

}  // namespace covey::bench
