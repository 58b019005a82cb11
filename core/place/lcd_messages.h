// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Between the messages of place recognition and what it computes with. What comes from the radio may be anything: whatever is
// not what its type says it is comes back as nothing.

#include <covey/lcd_features_t.hpp>
#include <covey/lcd_words_t.hpp>
#include <covey/loop_t.hpp>
#include <optional>

#include "core/base/time.h"
#include "core/pgo/robot_graph.h"
#include "core/place/bag_of_words.h"
#include "core/place/features.h"
#include "core/place/verification.h"

namespace covey::place {

using pgo::KeyframeName;

constexpr int kMostFeatures = 2000;  // of one keyframe, that anybody may send
constexpr int kMostRobots = 1000;

lcd_words_t words_message(const KeyframeName& name, Utime utime, const BagOfWords& bag,
                          std::uint64_t vocabulary);
// `words`: how many the vocabulary has.
std::optional<BagOfWords> bag_from(const lcd_words_t& message, int words);

lcd_features_t features_message(const KeyframeName& name, Utime utime, int to, const FrameFeatures& features);
std::optional<FrameFeatures> features_from(const lcd_features_t& message);

// utime, stream and number are left 0.
loop_t loop_message(const KeyframeName& a, const KeyframeName& b, const Verification& verification,
                    double similarity);
bool is_good(const loop_t& loop);
// The same closure with the same numbers: what two robots' pose graphs take for one.
bool is_same_closure(const loop_t& a, const loop_t& b);

}  // namespace covey::place
