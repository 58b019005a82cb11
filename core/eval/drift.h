// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Relative pose error (RPE): how far odometry is off after a stretch of way, per metre, wherever the stretch begins and whatever came before. For poses i and j
// with L metres of the reference's way between them
//
//   E = (T_W_i^-1 T_W_j)^-1 (T_O_i^-1 T_O_j)          W: reference, O: estimate
//
// contributes |trans E| / L and |angle E| / L. Source: Zhang and Scaramuzza, "A tutorial on quantitative trajectory evaluation for visual(-inertial)
// odometry", IROS 2018; lengths as in its EuRoC examples.

#include "core/eval/ate.h"

namespace covey {

struct DriftOptions {
  std::vector<double> lengths_m = {8.0, 16.0, 24.0, 32.0, 40.0};
  int every = 10;  // poses from the beginning of one stretch to that of the next
  AteOptions stamps;
};

struct Drift {
  int stretches = 0;                 // 0: the way is too short, and the figures mean nothing
  double translation_percent = 0.0;  // means over all stretches of all lengths
  double rotation_deg_per_m = 0.0;
};

Drift odometry_drift(const TrajectoryPair& pair, const DriftOptions& options = {});

}  // namespace covey
