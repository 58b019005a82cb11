// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a robot carries and where: IMU, stereo cameras, depth camera. Read from one file (configs/sensors), to which a robot's
// configuration points with `sensors: FILE`, relative to itself:
//
//   imu:   {rate_hz: 200, gyro_noise: 1.7e-4, gyro_walk: 1.9e-5, accel_noise: 2.0e-3, accel_walk: 3.0e-3, gyro_range: 17.4, accel_range: 176}
//   left:  {width: 752, height: 480, intrinsics: [fx, fy, cx, cy], distortion: [k1, k2, p1, p2], T_B_C: [16 numbers, row by row]}
//          fisheye: distortion_model: equidistant, distortion: [k1, k2, k3, k4]
//   right: likewise; left out for a single camera
//   depth: likewise, and near_m, far_m; left out where there is none
//   mono:  true: as if there were no right camera
//
// Instead of left, right and imu (which may still say more of the IMU), files of other tools, relative to this one (calibration_files.h):
//
//   kalibr: camchain-imucam.yaml    kalibr_imu: imu.yaml
//   euroc: mav0                     a folder with cam0/sensor.yaml, cam1 and imu0

#include <filesystem>
#include <limits>
#include <optional>

#include "core/geometry/camera.h"
#include "core/geometry/se3.h"

namespace covey {

// Continuous-time densities, per axis (Forster et al., T-RO 2017, section IV).
struct ImuNoise {
  double rate_hz = 200.0;
  double gyro_noise = 1.6968e-4;  // rad / s / sqrt(Hz)
  double gyro_walk = 1.9393e-5;   // rad / s^2 / sqrt(Hz)
  double accel_noise = 2.0e-3;    // m / s^2 / sqrt(Hz)
  double accel_walk = 3.0e-3;     // m / s^3 / sqrt(Hz)
  // Readings of at least that much may be anything.
  double gyro_range = std::numeric_limits<double>::infinity();   // rad/s
  double accel_range = std::numeric_limits<double>::infinity();  // m/s^2
};

struct MountedCamera {
  PinholeCamera camera;
  SE3 T_B_C;
};

struct DepthCamera {
  PinholeCamera camera;  // not distorted
  SE3 T_B_C;
  double near_m = 0.3;
  double far_m = 10.0;
};

struct Rig {
  ImuNoise imu;
  MountedCamera left;
  std::optional<MountedCamera> right;
  std::optional<DepthCamera> depth;
};

// InputError that names file, line and key.
Rig read_rig(const std::filesystem::path& file);

}  // namespace covey
