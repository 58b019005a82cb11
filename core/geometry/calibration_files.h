// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Calibration as other people's tools write it. InputError that names file, line and key for what is not there or not understood.
//
//   Kalibr   camchain-imucam.yaml   cam0, cam1: camera_model pinhole, distortion_model radtan, equidistant or none, T_cam_imu (or for cam1 T_cn_cnm1)
//            imu.yaml               noise densities, random walks, update_rate
//   EuRoC    cam0/sensor.yaml       T_BS, resolution, intrinsics, distortion
//            imu0/sensor.yaml       noise densities, random walks, rate_hz
//
// Body B is the IMU. A chain's time shifts must be small: stamps of IMU and cameras are one clock's here.

#include <filesystem>
#include <vector>

#include "core/geometry/rig.h"

namespace covey {

// In the order of their numbers.
std::vector<MountedCamera> read_kalibr_cameras(const std::filesystem::path& file);
ImuNoise read_kalibr_imu(const std::filesystem::path& file);

MountedCamera read_euroc_camera(const std::filesystem::path& file);
ImuNoise read_euroc_imu(const std::filesystem::path& file);

}  // namespace covey
