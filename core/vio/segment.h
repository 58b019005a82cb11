// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One segment of odometry from its start on: the smoother's window, the frames since its newest keyframe, and what the team was told.

#include <span>

#include "core/imu/propagate.h"
#include "core/vio/output.h"
#include "core/vio/start.h"
#include "core/vio/window.h"

namespace covey::vio {

class Segment {
 public:
  // From the states that were found at some frames (start.h), which become keyframes and are adjusted with all that the IMU says. result gets the
  // state of each, and the first keyframe for the team at the last one.
  Segment(const Rig& rig, const VioOptions& options, std::span<const StartFrame> frames, const Start& start,
          VioFrame& result);

  // The next frame with the samples since the last one; result gets its state and perhaps a keyframe for the team.
  void add(const FrameTracks& frame, const std::vector<ImuSample>& samples, VioFrame& result);

  // What the IMU says since the last frame, anew or one sample further.
  void set_ahead(const std::vector<ImuSample>& samples);
  void add_imu(const ImuSample& before, const ImuSample& sample);
  // What the IMU would measure if the vehicle went on as it is: turning as between the last two frames, without acceleration.
  ImuSample steady(Utime utime) const;
  // The state at utime, that of the last of these samples.
  VioState predict(Utime utime) const;

  Utime name() const { return name_; }
  Utime last_utime() const { return last_utime_; }
  const NavState& last_state() const { return last_; }
  // Why the segment must be given up, or null.
  const char* trouble() const;

 private:
  bool keyframe_due(const FrameTracks& frame, const SE3& T_O_B, int used) const;
  bool team_due(Utime utime, const SE3& T_O_B) const;
  double parallax(const FrameTracks& frame, const SE3& T_O_B) const;
  void take_keyframe_state();
  void cut_team_keyframe(VioFrame& result);

  Rig rig_;
  StereoRig stereo_;
  VioOptions options_;
  Window window_;
  Utime name_ = 0;

  // Of the newest keyframe, and since.
  Landmarks landmarks_;
  int landmarks_in_keyframe_ = 0;
  NavState keyframe_state_;
  Matrix15d keyframe_covariance_ = Matrix15d::Zero();
  std::vector<ImuSample> since_keyframe_;
  Preintegration from_keyframe_;

  // Of the last frame, and since.
  Utime last_utime_ = 0;
  NavState last_;
  Eigen::Vector3d turning_ = Eigen::Vector3d::Zero();  // since the frame before, rad/s
  Matrix15d last_covariance_ = Matrix15d::Zero();
  Utime last_used_utime_ = 0;  // when images last moved the estimate
  double blind_s_ = 0.0;       // that neither images nor IMU have said anything
  Preintegration ahead_;
  bool ahead_measured_ = true;  // without a gap, and nothing made up

  Utime team_utime_ = 0;  // of the last keyframe for the team
  int team_keyframes_ = 0;
};

}  // namespace covey::vio
