// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Trains a vocabulary: hierarchical k-medians on binary descriptors. A node's descriptors are split around k centres (chosen one
// after the other with probability proportional to the squared distance to the nearest one so far: k-means++, Arthur and
// Vassilvitskii, SODA 2007); a centre is the majority of its descriptors bit by bit, which is their median under the
// Hamming distance; repeated until nothing moves. The same images and seed give the same vocabulary.

#include <cstdint>
#include <vector>

#include "core/place/vocabulary.h"

namespace covey::place {

struct TrainingOptions {
  int branching = 10;
  int depth = 4;
  int iterations = 15;      // of one split, at most
  int least_to_split = 40;  // descriptors; below that a node is a word
  std::uint64_t seed = 1;
};

// Of the descriptors of each image. COVEY_CHECKs that there are any.
Vocabulary train_vocabulary(const std::vector<std::vector<Descriptor>>& images,
                            const TrainingOptions& options = {});

}  // namespace covey::place
