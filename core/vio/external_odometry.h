// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// States and keyframes from poses that somebody else's odometry tells, of the same form as VioEstimator's.
//
// Its frame may begin anywhere: O is put at the first pose of the segment, turned about z so that the first yaw is zero; z is taken to point up as it is given. A new
// value of its segment, or a step faster than `max_speed_mps`, opens a new segment. What the steps are uncertain by adds up along the way from keyframe
// to keyframe:
//
//   Sigma <- Ad(dT^-1) Sigma Ad(dT^-1)^T + Sigma_step,   over [rho; phi], in the newest body frame
//
// where a step without a covariance of its own gets  sigma^2 (|rho| + 0.5 m/rad |phi|)  per axis: a random walk along the way.

#include <optional>

#include "core/vio/options.h"
#include "core/vio/output.h"

namespace covey::vio {

struct ExternalOdometryOptions {
  double sigma_m = 0.02;   // per axis and square root of a metre of way
  double sigma_deg = 0.3;  // likewise
  double gravity_sigma_deg =
      0.0;  // of its z axis against gravity; 0: not known, keyframes then have no gravity
  double max_speed_mps = 30.0;
};
ExternalOdometryOptions read_external_odometry_options(ConfigSection& section);

struct OdometryPose {
  Utime utime = 0;
  std::int64_t segment = 0;
  SE3 T_O_B;  // in the frame that the sender has
  Matrix6d covariance =
      Matrix6d::Zero();  // of the step since the pose before, [rho; phi] in B; zero: not known
};

// Since O began.
struct ExternalSegment {
  Utime name = 0;
  SE3 T_O_S;  // S: the sender's frame
  OdometryPose last;
  SE3 T_O_B;
  Matrix6d covariance = Matrix6d::Zero();           // of T_O_B
  Matrix6d keyframe_covariance = Matrix6d::Zero();  // of the way since the last keyframe
  VioKeyframe keyframe;                             // the last one
  int segments = 0;
};

class ExternalOdometry {
 public:
  ExternalOdometry(const VioOptions& options, const ExternalOdometryOptions& odometry)
      : options_(options), odometry_(odometry) {}

  // The state, and a keyframe where one is due; dropped: "late". So many late ones in a row that it is no disorder but another clock
  // begin a segment.
  VioFrame add(const OdometryPose& pose);

 private:
  void open(const OdometryPose& pose, VioFrame& frame);
  void step(const OdometryPose& pose, VioFrame& frame);
  bool begins_anew(const OdometryPose& pose) const;
  Matrix6d step_covariance(const OdometryPose& pose, const SE3& step) const;
  VioKeyframe make_keyframe(int id) const;

  VioOptions options_;
  ExternalOdometryOptions odometry_;
  std::optional<ExternalSegment> segment_;
  int late_ = 0;  // in a row
};

}  // namespace covey::vio
