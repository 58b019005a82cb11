// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What visual-inertial odometry tells. Poses in O, the odometry frame of the segment: origin at the first body position, z up, first yaw zero (body
// axes are turned upright by the shortest rotation). A segment is named by the utime of its first frame; O and ids begin anew with it.

#include <optional>
#include <string>
#include <vector>

#include "core/imu/state.h"

namespace covey::vio {

struct VioState {
  Utime utime = 0;
  Utime segment = 0;
  NavState state;  // W = O
  Matrix9d covariance = Matrix9d::
      Zero();  // of [rho; phi] in B and v_O (m, rad, m/s); position and yaw against the segment's start
  bool coasting = false;  // on the IMU alone, or across a gap of it that images have not yet filled
};

// What the team's pose graph gets (CONVENTIONS.md, frame K).
struct VioKeyframe {
  Utime utime = 0;
  Utime segment = 0;
  int id = 0;  // from 0 within the segment, without gaps
  SE3 T_O_K;
  SE3 T_P_K;                                  // relative to the keyframe before; identity where id = 0
  Matrix6d covariance = Matrix6d::Zero();     // of T_P_K, [rho; phi] in K; zero where id = 0
  Eigen::Vector3d gravity_K{0.0, 0.0, -1.0};  // unit vector, down
  double gravity_sigma_rad = 0.0;
};

enum class VioPhase { kStarting, kTracking, kCoasting };

struct VioHealth {
  VioPhase phase = VioPhase::kStarting;
  int tracks = 0;           // in the last frame
  int used = 0;             // of them, those that agree with the map and moved the estimate
  int outliers = 0;         // of them, those that do not agree
  double coasting_s = 0.0;  // since images last moved the estimate
  int segments = 0;         // opened so far
  std::string trouble;      // why the last segment was given up; empty: never
  std::string no_start;     // why none starts; empty: one has, or not enough has come in yet
};

struct VioFrame {
  // The state at this frame; when a segment starts, at all frames that it started from, in order of time. Empty before that.
  std::vector<VioState> states;
  std::vector<VioKeyframe> keyframes;  // in order of id
  VioHealth health;
  const char* dropped =
      nullptr;  // why the frame was not used: "late", "ahead_of_imu", "before_imu", "imu_gap"
};

}  // namespace covey::vio
