// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What an IMU measures on a motion. Sample k is at begin + k / rate_hz:
//
//   gyro = omega_B + b_g + n_g,   accel = R_W_B^T (a_W - g_W) + b_a + n_a
//
// with white noise of the densities of ImuNoise and biases that walk at random from a drawn start. Source of the discrete noise,
// sigma = density sqrt(rate) and walk sqrt(1 / rate): Crassidis, "Sigma-point Kalman filtering for integrated GPS and inertial navigation",
// 2006, appendix.

#include <cstdint>
#include <vector>

#include "core/geometry/rig.h"
#include "core/imu/state.h"
#include "core/sim/motion.h"

namespace covey::sim {

struct ImuOptions {
  ImuNoise noise;
  double gyro_bias_sigma = 0.03;   // rad/s, per axis, of the biases at the start
  double accel_bias_sigma = 0.05;  // m/s^2
};

struct ImuRecord {
  std::vector<ImuSample> samples;
  std::vector<ImuBias> biases;  // the true ones, at each sample
};

ImuRecord simulate_imu(const Motion& motion, const ImuOptions& options, std::uint64_t seed);

}  // namespace covey::sim
