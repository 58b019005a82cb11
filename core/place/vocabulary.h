// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A vocabulary of visual words: a tree of binary centres in which a descriptor walks from the root to the nearest child, again and
// again; the leaf where it ends is its word (Nister and Stewenius, "Scalable recognition with a vocabulary tree", CVPR 2006; for
// binary descriptors Galvez-Lopez and Tardos, "Bags of binary words", T-RO 2012). A word's weight is its inverse document
// frequency, ln(N / N_i), over the images of the training.
//
// As a file (little-endian): "COVEYVOC", uint32 format (1), uint32 nodes; of each node, breadth first from the root: uint8 children
// (0: a leaf, the words counting from 0 in this order), 32 bytes centre, float32 weight (0 for inner nodes); uint64 hash of
// all that, which is also the vocabulary's name on the air: other vocabularies' words mean something else.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/place/bag_of_words.h"
#include "core/place/descriptor.h"

namespace covey::place {

class Vocabulary {
 public:
  struct Node {
    Descriptor centre = {};
    std::uint8_t children = 0;
    float weight = 0.0F;
  };

  // Breadth first. COVEY_CHECKs that this is one tree.
  explicit Vocabulary(std::vector<Node> nodes);

  // Throws InputError with a sentence that names the file.
  static Vocabulary load(const std::filesystem::path& file);
  void save(const std::filesystem::path& file) const;

  int words() const { return words_; }
  std::uint64_t hash() const { return hash_; }
  double weight(int word) const {
    return nodes_[static_cast<std::size_t>(leaves_[static_cast<std::size_t>(word)])].weight;
  }

  int word(const Descriptor& descriptor) const;
  // Of the words that have a weight: those that stand in every image of the training have none.
  WordCounts counts(std::span<const Descriptor> descriptors) const;
  BagOfWords bag(const WordCounts& counts) const;  // empty where no word has a weight
  BagOfWords bag(std::span<const Descriptor> descriptors) const { return bag(counts(descriptors)); }

 private:
  std::vector<Node> nodes_;
  std::vector<int> first_child_;  // of inner nodes
  std::vector<int> word_of_;      // of leaves
  std::vector<int> leaves_;       // by word
  int words_ = 0;
  std::uint64_t hash_ = 0;
};

}  // namespace covey::place
