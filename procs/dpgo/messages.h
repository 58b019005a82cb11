// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Between what is on the bus and what the agent computes with.

#include <covey/keyframe_t.hpp>
#include <covey/loop_t.hpp>
#include <covey/loop_weights_t.hpp>
#include <covey/trajectory_t.hpp>
#include <optional>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/pgo/dgnc_round.h"
#include "core/pgo/robot_graph.h"

namespace covey {

// None where a quaternion is not of norm 1 within 1 %.
std::optional<pgo::Keyframe> keyframe_from(const keyframe_t& message);
std::optional<pgo::Loop> loop_from(const loop_t& message);

// In parts of at most 400. Segments without a place in W are left out.
std::vector<trajectory_t> trajectory_messages(const pgo::RoundResult& result, const pgo::GraphSnapshot& graph,
                                              Utime now);
std::vector<loop_weights_t> loop_weights_messages(const pgo::RoundResult& result, int robot, Utime now);

// The same for a file, ascending in time.
Trajectory trajectory_of(const pgo::RoundResult& result, const pgo::GraphSnapshot& graph);

}  // namespace covey
