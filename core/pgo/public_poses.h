// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Poses as they travel between the robots of a round: seven numbers for a rigid motion; for a lifted pose 16-bit differences
// to the one sent before, with one scale for all rotation columns and one for all translation columns of the message. Sender
// and receivers add the same differences, so they hold the same poses to the last bit, and what rounding left out of one
// message is part of the next.

#include <covey/dpgo_update_t.hpp>
#include <vector>

#include "core/pgo/block_solver.h"

namespace covey::pgo {

void append_pose(const SE3& T, std::vector<double>& values);  // qw qx qy qz tx ty tz
// Pose k of such a list.
SE3 pose_at(const std::vector<double>& values, int k);
SE3 pose_at(const std::vector<float>& values, int k);
// Whether all quaternions of such a list can be normalised.
bool poses_are_good(const std::vector<double>& values);
bool poses_are_good(const std::vector<float>& values);

// differences: r x 4n. Rows that are zero throughout, as those beyond the third are for robots whose starts were never
// lifted out of it, are not sent.
void encode_differences(const Lifted& differences, dpgo_update_t& message);
// Adds them; false, and nothing added, where the message does not fit the poses.
bool fits(const dpgo_update_t& message, const Lifted& poses);
void add_differences(const dpgo_update_t& message, Lifted& poses);

}  // namespace covey::pgo
