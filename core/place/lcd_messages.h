// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Between the messages of place recognition and what it computes with. What comes from the radio may be anything: whatever is
// not what its type says it is, is refused with a word that says why.

#include <covey/lcd_bag_t.hpp>
#include <covey/lcd_frame_t.hpp>
#include <covey/lcd_inventory_t.hpp>
#include <covey/loop_t.hpp>

#include "core/base/time.h"
#include "core/pgo/robot_graph.h"
#include "core/place/bag_of_words.h"
#include "core/place/features.h"
#include "core/place/inventory.h"
#include "core/place/verification.h"

namespace covey::place {

using pgo::KeyframeName;

constexpr int kMostFeatures = 2000;  // of one keyframe, that anybody may send
constexpr int kMostRobots = 1000;
inline bool is_robot(int robot) { return robot >= 0 && robot < kMostRobots; }

lcd_bag_t bag_message(const KeyframeName& name, Utime utime, const WordCounts& counts,
                      std::uint64_t vocabulary);
// `words`: how many the vocabulary has. Null and `counts` filled, else what is wrong: "id", "utime", or as decode_words says.
const char* read_bag(const lcd_bag_t& message, int words, WordCounts& counts);

lcd_frame_t frame_message(const KeyframeName& name, Utime utime, int to, const FrameFeatures& features);
// Null and `features` filled, else what is wrong: "id", "size", "noise", "camera", or as decode_points says.
const char* read_frame(const lcd_frame_t& message, FrameFeatures& features);

lcd_inventory_t inventory_message(int robot, Utime utime, std::int64_t vocabulary,
                                  const Inventory& inventory);
// Null and `inventory` filled, else what is wrong: "size", "robot", or as decode_ids says.
const char* read_inventory(const lcd_inventory_t& message, Inventory& inventory);

// utime, stream and number are left 0.
loop_t loop_message(const KeyframeName& a, const KeyframeName& b, const Verification& verification,
                    double similarity);
bool is_good(const loop_t& loop);
// The same closure with the same numbers: what two robots' pose graphs take for one.
bool is_same_closure(const loop_t& a, const loop_t& b);

}  // namespace covey::place
