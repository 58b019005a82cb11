// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What one robot's front end would have said on its bus while a pose graph grew: its keyframes, one a second,
// and each loop closure that it takes part in as soon as the later of its own keyframes is there. A function
// of the graph alone, so that a front end that is killed and started again says the same again, number for
// number.
//
// The odometry frame O is the robot's first pose. Poses of a graph have no stamps: keyframe `id` has
// keyframe_utime(id) (core/pgo/trajectories.h), and every segment and stream is named keyframe_utime(0).
// Covariances are isotropic, 1 / tau of translation and 1 / (2 kappa) of rotation per axis, from which
// CONVENTIONS.md's formulas return kappa and tau. Planar graphs stay in the plane z = 0.

#include <covey/keyframe_t.hpp>
#include <covey/loop_t.hpp>
#include <variant>
#include <vector>

#include "core/base/time.h"
#include "core/pgo/pose_graph.h"

namespace covey::sim {

using FrontEndMessage = std::variant<keyframe_t, loop_t>;

// In the order in which they are said, with utimes that do not decrease. The robot's odometry must join its
// poses without gaps (InputError that names the pose); edges that do not touch the robot are left out.
std::vector<FrontEndMessage> front_end_messages(const pgo::PoseGraph& graph, int robot);

Utime utime_of(const FrontEndMessage& message);

}  // namespace covey::sim
