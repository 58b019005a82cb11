// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Poses as they travel between the robots of a round once all know where they start: as steps to what was sent before.
// Sender and receivers add the same steps by the same arithmetic, so they hold the same poses to the last
// bit, and what rounding left out of one step is part of the next.
//
// A step is a rotation vector phi (Gibbs: R' = normalised(1, phi / 2) R) and t' - t, both in the common frame, where the
// keyframes of one robot move alike: each step is foretold from that of the keyframe before it, as if both were one rigid
// body, phi and t' - t + phi x (t_next - t), and what it differs from that travels in whole units, Rice-coded (bit_code.h)
// with one parameter for each of the six components. Components that are zero for all, as three are in a plane, cost
// nothing; keyframes that do not move, or need not be known, one bit.

#include <covey/dpgo_step_t.hpp>
#include <vector>

#include "core/geometry/se3.h"

namespace covey::pgo {

// Writes the steps from `sent` to `wanted` of the chosen poses into the message, in units of 1 / resolution of their root
// mean square.
void encode_steps(const std::vector<SE3>& sent, const std::vector<SE3>& wanted,
                  const std::vector<bool>& chosen, double resolution, dpgo_step_t& message);
// Takes the message's steps, none where its code is empty; false, and nothing changed, where it does not hold steps of that
// many poses, or sends one beyond any measure.
bool add_steps(const dpgo_step_t& message, std::vector<SE3>& poses);

}  // namespace covey::pgo
