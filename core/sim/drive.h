// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A ground robot drives along a path of straight pieces: it stands still for a moment, speeds up, rounds the corners, looks where it goes,
// and its suspension bounces and sways a little while it rolls. The motion is a quintic spline of x, y, z, roll, pitch and yaw with
// R_W_B = Rz(yaw) Ry(pitch) Rx(roll); body x forward, z up.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/sim/motion.h"

namespace covey::sim {

struct DriveOptions {
  double speed = 1.35;         // m/s
  double stand_s = 1.25;       // before it starts
  double acceleration = 0.8;   // m/s^2
  double corner_m = 2.7;       // along the path over which a corner is rounded, three times over
  double body_height_m = 0.5;  // of the IMU above the path
  double bounce_m = 0.7e-3;    // standard deviations of the suspension's play at full speed
  double sway_deg = 0.12;
  double suspension_s = 0.12;  // its correlation time
};

// Metres that a robot gets in this time, along the path with its corners; round them it is as much slower as its way is shorter.
double driven_length(const DriveOptions& options, double seconds);

// path: corners in W, on the ground, no two successive ones equal; longer than what is driven. The motion is known from begin to begin +
// seconds.
Motion drive(const std::vector<Eigen::Vector3d>& path, const DriveOptions& options, Utime begin,
             double seconds, std::uint64_t seed);

}  // namespace covey::sim
