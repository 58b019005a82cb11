// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/imu.h"

#include <cmath>
#include <random>

namespace covey::sim {

ImuRecord simulate_imu(const Motion& motion, const ImuOptions& options, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma) {
    const double x = normal(random);
    const double y = normal(random);
    const double z = normal(random);
    return Eigen::Vector3d(sigma * Eigen::Vector3d(x, y, z));
  };
  const ImuNoise& noise = options.noise;
  const double per_sample = std::sqrt(noise.rate_hz);
  ImuBias bias{draw(options.gyro_bias_sigma), draw(options.accel_bias_sigma)};
  ImuRecord record;
  for (int k = 0;; ++k) {
    const Utime utime = motion.begin + from_seconds(k / noise.rate_hz);
    if (utime > motion.end) break;
    const MotionState state = motion.at(utime);
    const Eigen::Vector3d force = state.T_W_B.rotation.inverse() * Eigen::Vector3d(state.a_W - kGravity);
    record.samples.push_back({.utime = utime,
                              .gyro = state.omega_B + bias.gyro + draw(noise.gyro_noise * per_sample),
                              .accel = force + bias.accel + draw(noise.accel_noise * per_sample)});
    record.biases.push_back(bias);
    bias.gyro += draw(noise.gyro_walk / per_sample);
    bias.accel += draw(noise.accel_walk / per_sample);
  }
  return record;
}

}  // namespace covey::sim
