// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The first states of a segment, from some frames and the IMU between them; standing or moving makes no difference, since two cameras know depth:
//
//   1. the frames are placed by their images alone, each against the landmarks of those before, then all together (a small bundle adjustment);
//      rotations start from the gyro;
//   2. the gyro's bias is what makes its rotations those of the images;
//   3. velocities and gravity follow from a linear system, with R and p of the images and dv, dp of the IMU (preintegration.h):
//        R_i^T (p_j - p_i) - dp = T R_i^T v_i + T^2 / 2 R_i^T g,   dv = R_i^T (v_j - v_i) - T R_i^T g
//   4. the frame is turned upright: origin at the first body position, z against gravity, body axes turned by the shortest rotation.
//
// After Qin, Li, Shen, "VINS-Mono", T-RO 2018, section V. The accelerometer's bias is left to the smoother. One camera knows its places up to a scale only
// (place_mono.h), which is one more unknown of step 3: it takes a longer stretch, with parallax and with accelerations, so nothing starts while it stands.

#include <span>
#include <string>
#include <vector>

#include "core/vio/frame_pose.h"
#include "core/vio/options.h"

namespace covey::vio {

struct StartFrame {
  FrameTracks tracks;
  std::vector<ImuSample> samples;  // since the frame before
};

struct Start {
  std::vector<NavState> states;  // one per frame; W = O
  std::string failure;           // why there are none; empty: there are
};

Start find_start(const Rig& rig, const VioOptions& options, std::span<const StartFrame> frames);

}  // namespace covey::vio
