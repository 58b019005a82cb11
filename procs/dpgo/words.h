// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What dpgo says in its log, for people.

#include <string>
#include <vector>

#include "core/pgo/dgnc_agent.h"

namespace covey {

// "round 3 of robots 0 1 2: cost 41.25, gradient 0.00234, weights 5 at 0 / 0 between / 31 at 1, 60 updates in 9 stages,
// 48.2 kB, 3.1 s": cost, gradient and weights are this robot's share, which add up to the team's.
std::string round_line(const pgo::RoundResult& result, const pgo::RoundAccount& account);

// "robots 0 1 are solved together; 2 is apart: not heard for 12 s; 3 is apart: no closure with the others"
std::string team_line(const std::vector<int>& together, const std::vector<pgo::ApartRobot>& apart);

}  // namespace covey
