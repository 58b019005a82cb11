// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A keyframe as place recognition has it.

#include "core/place/bag_of_words.h"
#include "core/place/features.h"
#include "tests/bench/place/view.h"

namespace covey::bench {

struct Seen {
  View view;
  place::BagOfWords bag;
  place::FrameFeatures features;
};

}  // namespace covey::bench
