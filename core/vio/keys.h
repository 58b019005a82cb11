// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The names of vio's variables: pose x, velocity v and bias b of a frame, by its number; landmark l, by its track.

#include "core/graph/key.h"

namespace covey::vio {

inline graph::Key pose_key(std::uint64_t frame) { return {'x', frame}; }
inline graph::Key velocity_key(std::uint64_t frame) { return {'v', frame}; }
inline graph::Key bias_key(std::uint64_t frame) { return {'b', frame}; }
inline graph::Key landmark_key(std::int64_t track) { return {'l', static_cast<std::uint64_t>(track)}; }

}  // namespace covey::vio
