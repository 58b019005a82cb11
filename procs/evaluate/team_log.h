// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What D-GNC said of the loop closures of a pose graph, read from the logs of the robots' buses
// (LOOP_WEIGHTS).

#include <filesystem>
#include <vector>

#include "core/eval/loop_weights.h"

namespace covey {

// The weights of each robot's last round. Both robots of a closure speak of it; the one with the lower id owns
// the weight, and only its word is here.
std::vector<SaidWeight> weights_in_logs(const std::vector<std::filesystem::path>& logs);

}  // namespace covey
