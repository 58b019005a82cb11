// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How a body moves: a function of time, with the derivatives that an IMU measures.
//
//   d/dt p_W_B = v_W,   d/dt v_W = a_W,   d/dt R_W_B = R_W_B omega_B^
//
// W has z up; gravity is not part of a_W, so that an accelerometer at rest reads R_W_B^T (0 - g_W).

#include <Eigen/Core>
#include <functional>

#include "core/base/time.h"
#include "core/geometry/se3.h"

namespace covey::sim {

struct MotionState {
  SE3 T_W_B;
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d a_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d omega_B = Eigen::Vector3d::Zero();
};

struct Motion {
  Utime begin = 0;  // first and last utime at which it is known
  Utime end = 0;
  std::function<MotionState(Utime)> at;
};

}  // namespace covey::sim
