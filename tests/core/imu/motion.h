// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A smooth motion in closed form and the IMU that would ride on it: sums of sines for position and rotation vector, which begin from rest
// after `still_s` seconds.

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/rig.h"
#include "core/imu/preintegration.h"
#include "tests/core/geometry/random.h"

namespace covey::testing {

struct AnalyticMotion {
  Eigen::Vector3d reach_m{1.0, 0.8, 0.4};    // amplitudes of position
  Eigen::Vector3d turn_rad{0.3, 0.25, 0.8};  // amplitudes of the rotation vector
  Eigen::Vector3d rate{0.9, 1.3, 1.7};       // rad/s
  double still_s = 0.0;                      // at rest until then, and within one second at full swing

  NavState state(Utime utime) const {
    const Wave position = wave(reach_m, 0.0, utime);
    const Wave rotation = wave(turn_rad, 0.7, utime);
    return {{SO3::exp(rotation.value), position.value}, position.slope, {}};
  }
  // Without noise and bias.
  ImuSample imu(Utime utime) const {
    const Wave position = wave(reach_m, 0.0, utime);
    const Wave rotation = wave(turn_rad, 0.7, utime);
    return {utime, SO3::right_jacobian(rotation.value) * rotation.slope,
            SO3::exp(rotation.value).inverse() * Eigen::Vector3d(position.curve - kGravity)};
  }

 private:
  struct Wave {
    Eigen::Vector3d value, slope, curve;
  };
  // fade(t) (sin(rate t + phase)), with a smooth fade from 0 to 1.
  Wave wave(const Eigen::Vector3d& amplitude, double phase, Utime utime) const {
    const double t = to_seconds(utime) - still_s;
    const double s = still_s > 0.0 ? std::clamp(t, 0.0, 1.0) : 1.0;
    const bool fading = s > 0.0 && s < 1.0;
    const double fade = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    const double fade_slope = fading ? 30.0 * s * s * (1.0 - s) * (1.0 - s) : 0.0;
    const double fade_curve = fading ? 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) : 0.0;
    Wave w;
    for (int k = 0; k < 3; ++k) {
      const double angle = rate[k] * t + phase * (k + 1);
      const double sine = std::sin(angle);
      const double slope = rate[k] * std::cos(angle);
      w.value[k] = amplitude[k] * fade * sine;
      w.slope[k] = amplitude[k] * (fade_slope * sine + fade * slope);
      w.curve[k] =
          amplitude[k] * (fade_curve * sine + 2.0 * fade_slope * slope - fade * rate[k] * rate[k] * sine);
    }
    return w;
  }
};

inline std::vector<ImuSample> sample_imu(const AnalyticMotion& motion, Utime from, Utime until, Utime step) {
  std::vector<ImuSample> samples;
  for (Utime t = from; t <= until; t += step) samples.push_back(motion.imu(t));
  return samples;
}

// White noise of the given densities and one wandering bias on samples that are evenly spaced.
inline void add_imu_errors(const ImuNoise& noise, ImuBias bias, RandomGeometry& random,
                           std::vector<ImuSample>& samples) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::size_t i = std::max<std::size_t>(k, 1);
    const double dt = to_seconds(samples[i].utime - samples[i - 1].utime);
    samples[k].gyro += bias.gyro + random.vector<3>(noise.gyro_noise / std::sqrt(dt));
    samples[k].accel += bias.accel + random.vector<3>(noise.accel_noise / std::sqrt(dt));
    bias.gyro += random.vector<3>(noise.gyro_walk * std::sqrt(dt));
    bias.accel += random.vector<3>(noise.accel_walk * std::sqrt(dt));
  }
}

}  // namespace covey::testing
