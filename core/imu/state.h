// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What an IMU measures and what it moves. Body B = IMU; W here is any frame whose z axis points up against gravity (a robot's O).
//
//   gyro  = omega_B + b_g + noise                    rad/s
//   accel = R_W_B^T (a_W - g_W) + b_a + noise        m/s^2: specific force, +9.81 upwards at rest

#include <Eigen/Core>

#include "core/base/time.h"
#include "core/geometry/se3.h"

namespace covey {

using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;
using Matrix15d = Eigen::Matrix<double, 15, 15>;

inline const Eigen::Vector3d kGravity{0.0, 0.0, -9.81};  // g_W

struct ImuSample {
  Utime utime = 0;
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();
  bool measured =
      true;  // false: made up, where the sensor was silent or at the end of its range; counts for little
};

struct ImuBias {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel = Eigen::Vector3d::Zero();

  // As a variable of a graph: [gyro; accel].
  Vector6d vector() const {
    Vector6d v;
    v << gyro, accel;
    return v;
  }
  static ImuBias from_vector(const Vector6d& v) { return {v.head<3>(), v.tail<3>()}; }
};

struct NavState {
  SE3 T_W_B;
  Eigen::Vector3d v_W = Eigen::Vector3d::Zero();
  ImuBias bias;
};

}  // namespace covey
