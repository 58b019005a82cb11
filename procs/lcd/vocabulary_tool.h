// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Trains lcd's vocabulary from images: files, folders (with all below them, by name) and sensor logs (STEREO, both cameras); or takes one of DBoW2's.

#include <filesystem>
#include <vector>

#include "core/place/descriptor.h"
#include "core/place/vocabulary_training.h"

namespace covey {

struct VocabularyTool {
  std::vector<std::filesystem::path> sources;
  std::filesystem::path dbow2;  // instead of sources
  std::filesystem::path out;
  int every = 1;  // image of each source that is taken
  place::TrainingOptions training;

  // Prints what it read and made; the exit code. Throws InputError.
  int run() const;

 private:
  place::Vocabulary train() const;
};

}  // namespace covey
