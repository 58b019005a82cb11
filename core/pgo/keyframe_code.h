// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A robot's public keyframes as the others get to know them: each by the motion from the one before it, in whole units
// (range_code.h). The sender, too, goes on from what the others have understood, so rounding errors do not add up along the
// way; what is left of them travels with the first steps (pose_steps.h).
//
// A rotation is the three smallest components of its quaternion, the fourth being the root of what they leave to 1.

#include <covey/dpgo_keyframes_t.hpp>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/pgo/pose_steps.h"

namespace covey::pgo {

struct PublicKeyframe {
  int segment = 0;  // place in dpgo_join_t.segments
  int id = 0;
  SE3 T_S_K;  // in the frame that dpgo_join_t.solutions names
};

// keyframes: ascending by segment and id. units: coarser ones are taken where the keyframes are too far from each other.
void encode_keyframes(const std::vector<PublicKeyframe>& keyframes, const PoseUnits& units,
                      dpgo_keyframes_t& message);
// None where the message does not hold keyframes, or one beyond any measure.
std::optional<std::vector<PublicKeyframe>> decode_keyframes(const dpgo_keyframes_t& message);

}  // namespace covey::pgo
