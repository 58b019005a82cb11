// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The words of an image in few bits. The weights of a bag of words follow from how often each word occurs, by a vocabulary that both
// sides have; so what is sent of each word, ascending, is how many were left out before it, and its count less 1, which mostly is 0,
// range-coded. Nothing is lost: a bag made from what was sent is the sender's, bit for bit.

#include <cstdint>
#include <vector>

#include "core/place/bag_of_words.h"

namespace covey::place {

std::vector<std::uint8_t> encode_words(const WordCounts& counts);

// `n` different words of a vocabulary that has `words`, with no more features (`most`) in all. Null and `counts` filled, else what is
// wrong: "size" (n), "words" (that are not in the vocabulary), "counts", "code" (it does not end where it should).
const char* decode_words(const std::vector<std::uint8_t>& code, int n, int words, int most,
                         WordCounts& counts);

}  // namespace covey::place
