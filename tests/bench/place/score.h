// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a team has found against what there was to find. A closure is true within limits of the true pose. An overlap episode is a stretch
// of a robot's way, at most 5 m of it, on all keyframes of which some keyframe of a certain other robot, of whatever time, is near
// (2 m, 20 deg); it is found when a true closure joins it to that robot.

#include <covey/loop_t.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/bench/place/view.h"

namespace covey::bench {

// Of one place: what makes an overlap.
bool are_near(const View& a, const View& b);

struct Limits {
  double translation_m = 0.5;
  double rotation_deg = 5.0;
};

// "accepted", "true", "wrong": [sentences], "median_m", "median_deg", "worst_m", "worst_deg", "nees" (mean of the true ones; 6 would be
// honest), "nees_median", "episodes", "episodes_found", "recall", "pairs": [{"a", "b", "accepted", "true"}], "metres".
nlohmann::json score(const Views& views, const std::vector<loop_t>& loops, const Limits& limits);

}  // namespace covey::bench
