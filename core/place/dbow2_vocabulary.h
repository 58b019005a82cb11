// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Reads a vocabulary of DBoW2's (Galvez-Lopez and Tardos, "Bags of binary words", T-RO 2012) for descriptors of 32 bytes, gzipped or not, in
// either of the forms that are about:
//
//  - Text (ORB-SLAM's ORBvoc.txt): a line "k L scoring weighting", then one for each node but the root, numbered from 1 in their order:
//    its parent (0: the root), 1 for a word and 0 otherwise, 32 numbers of 0 to 255, its weight.
//  - OpenCV's YAML (DBoW2's own): "vocabulary:" with k, L, scoringType, weightingType, then "nodes:", of each nodeId, parentId, weight, descriptor (32
//    numbers in quotes), then "words:", of each wordId and nodeId: the nodes without children.
//
// Tree and weights are taken; how words are counted and bags compared is always as in bag_of_words.h, whatever scoring and weighting say.

#include <filesystem>

#include "core/place/vocabulary.h"

namespace covey::place {

// Words are numbered breadth first. Throws InputError with file, line and reason.
Vocabulary read_dbow2(const std::filesystem::path& file);

}  // namespace covey::place
