// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Visual-inertial odometry: IMU samples and tracked points in, states and keyframes out. A fixed-lag smoother: poses, velocities, biases and
// landmarks of the last keyframes are estimated together from preintegrated IMU (core/imu), reprojections in both cameras (projection_factor.h)
// and what older keyframes left behind as a linear prior (core/graph/marginal.h). Frames between keyframes are placed against the landmarks as they
// are (frame_pose.h).
//
// A segment starts from some 0.7 s of frames, standing or moving, without help from outside (start.h). When images fail it goes on with the IMU and
// says so; when that lasts too long, or estimates stop making sense, the segment is given up and a new one starts by itself.
//
// Nothing that comes in makes it throw: what cannot be used is named in the result.

#include <memory>

#include "core/geometry/rig.h"
#include "core/imu/imu_buffer.h"
#include "core/vio/options.h"
#include "core/vio/output.h"
#include "core/vision/tracks.h"

namespace covey::vio {

class VioEstimator {
 public:
  VioEstimator(const Rig& rig, const VioOptions& options);
  ~VioEstimator();
  VioEstimator(const VioEstimator&) = delete;
  VioEstimator& operator=(const VioEstimator&) = delete;

  // In order of time. Why the sample was not taken as it is ("not_finite", "late", "ahead": far ahead of the one before and not confirmed by the next,
  // "saturated": its time counts, its readings do not), or null.
  const char* add_imu(const ImuSample& sample);
  // Where the IMU is silent: its readings are made up until then, as of a motion that goes on as it is, and count for little. False where there is no such motion,
  // or where the IMU has been silent for too long.
  bool bridge_imu(Utime until);
  // The time of the last IMU sample; a frame may be added once it is no later than that. 0 before the first.
  Utime imu_until() const;

  // Of the left camera, R_from_until, from the gyro: where tracked points will have gone. Identity where the samples do not cover it.
  SO3 predict_rotation(Utime from, Utime until) const;

  VioFrame add_frame(const FrameTracks& frame);

  // The state at the last IMU sample; nothing before a segment has started.
  std::optional<VioState> predict() const;

  const VioHealth& health() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace covey::vio
