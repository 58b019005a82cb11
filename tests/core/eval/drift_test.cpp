// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/drift.h"

#include <catch2/catch.hpp>

namespace covey {
namespace {

// 100 m straight on, a pose every 10 cm; `scale` times as long, turning by `yaw_per_m`.
Trajectory drive(double scale, double yaw_per_m) {
  Trajectory way;
  SE3 pose;
  const SE3 step{SO3::exp({0.0, 0.0, 0.1 * yaw_per_m}), {0.1 * scale, 0.0, 0.0}};
  for (int k = 0; k <= 1000; ++k) {
    way.push_back({kUsPerSecond + 50'000 * k, pose});
    pose = pose * step;
  }
  return way;
}

TEST_CASE("odometry that is 2 % too long drifts by 2 %, wherever its frame is") {
  Trajectory estimate = drive(1.02, 0.0);
  const SE3 T{SO3::exp({0.3, -0.2, 2.0}), {5.0, 6.0, 7.0}};
  for (StampedPose& pose : estimate) pose.pose = T * pose.pose;
  const Drift drift = odometry_drift({estimate, drive(1.0, 0.0)});
  CHECK(drift.stretches > 300);
  CHECK(drift.translation_percent == Approx(2.0).epsilon(1e-6));
  CHECK(drift.rotation_deg_per_m == Approx(0.0).margin(1e-6));
}

TEST_CASE("odometry that turns too much drifts by the angle per metre") {
  const Drift drift = odometry_drift({drive(1.0, 1e-3), drive(1.0, 0.0)});
  CHECK(drift.rotation_deg_per_m == Approx(1e-3 * 180.0 / M_PI).epsilon(1e-6));
  CHECK(drift.translation_percent > 0.3);  // about half of the angle, in radians, after so many metres
}

TEST_CASE("a way that is shorter than every length has no drift") {
  Trajectory estimate = drive(1.02, 0.0);
  estimate.resize(70);
  CHECK(odometry_drift({estimate, drive(1.0, 0.0)}).stretches == 0);
}

}  // namespace
}  // namespace covey
