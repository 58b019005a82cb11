// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What is true of a simulated team, as files.

#include <filesystem>
#include <string>

#include "core/sim/scenario.h"
#include "procs/sim/simulate.h"

namespace covey {

// EuRoC's state_groundtruth_estimate0/data.csv: a row at every sample of the IMU, 17 columns (stamp in ns, p_W, q_W_B as w x y z, v_W, biases
// of gyroscope and accelerometer).
std::string format_states(const sim::Ride& ride);

// DIR/world.ply, labels.json, contacts.yaml, robot<i>.tum and .csv, and sim.json: what was asked for, the lengths driven, and for recorded
// motion the smoother's figures.
void write_truth(const SimOptions& options, const sim::Scenario& scenario);

// Every sequence in DATA/euroc/motion, whole, through the smoother; the figures as JSON.
void write_smoothing_figures(const std::filesystem::path& data, const ImuNoise& imu,
                             const std::filesystem::path& file);

}  // namespace covey
