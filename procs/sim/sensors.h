// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One robot's ride, measurement by measurement, in order of time.

#include "core/sim/cameras.h"
#include "core/sim/scenario.h"
#include "procs/sim/sink.h"

namespace covey {

// Without cameras, the IMU alone.
void run_sensors(const sim::Ride& ride, sim::SensorCameras* cameras, bool has_depth, SensorSink& sink);

}  // namespace covey
