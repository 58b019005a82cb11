// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The world `grid` as files: DIR/robot<i>.csv, the robot's measurements (core/pgo/robot_csv.h), and
// DIR/robot<i>_truth.tum, where it really was.

#include "procs/sim/simulate.h"

namespace covey {

void write_grid(const SimOptions& options);

}  // namespace covey
