// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How much memory a keyframe takes in a loop finder, by how much of the process is in memory before and after: words, index, features, and what the
// exchange knows of it.

#include <memory>

#include "core/place/lcd_agent.h"

namespace covey::bench {

struct MemoryUse {
  double own_kb = 0.0;    // kB (1000 bytes) of a robot's own keyframe
  double other_kb = 0.0;  // of one that it heard of
};

// Of so many keyframes of either kind, whose points have random descriptors: more different words than a picture has.
MemoryUse memory_of(const std::shared_ptr<const place::Vocabulary>& vocabulary,
                    const place::LcdOptions& options, int features, int keyframes);

}  // namespace covey::bench
