// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A motion that a real IMU measured and that a simulated camera can see. EuRoC's ground truth cannot be flown as it is: it jumps by up to
// 13 cm within 5 ms, its world is tilted against gravity by up to 0.15 deg, and its accelerations are not those of the IMU. So a batch
// smoother finds the motion that explains the IMU with its data-sheet noise and stays at the ground truth within its accuracy:
//
//   sum |ImuFactor|^2 + |BiasWalk|^2 + rho(|p_G - c - R (p_W - c)|^2 / sigma_p^2) + rho(|Log(R_G_B^-1 R R_W_B)|^2 / sigma_R^2)
//
// over nodes (pose, velocity, biases) at every `stride`-th sample of the IMU and one tilt R = Exp([x, y, 0]) of the ground truth's world G
// against W, whose z is up, about the middle c of the flight. Between nodes the samples are integrated from both ends by the midpoint rule,
// and one is blended into the other. In W, the motion is the reference truth.

#include <string>
#include <vector>

#include "core/geometry/rig.h"
#include "core/graph/factor.h"
#include "core/sim/euroc_files.h"
#include "core/sim/imu.h"
#include "core/sim/motion.h"

namespace covey::sim {

struct EurocOptions {
  ImuNoise imu;
  double position_sigma_m = 0.003;  // of the ground truth: Vicon
  double rotation_sigma_deg = 0.5;
  double robust_width = 4.0;  // Huber's, in sigmas
  int stride = 10;            // samples between nodes
};

// MH_*: the machine hall's ground truth comes from a Leica tracker, which is less exact than the Vicon room's.
EurocOptions euroc_options(const std::string& sequence, const ImuNoise& imu);

// Residual of a ground-truth position, in units of its sigma (tilt: x, y of the rotation vector).
struct TiltedPosition {
  using Variables = graph::VariableList<SE3, graph::Vector<2>>;
  static constexpr int kDim = 3;

  Eigen::Vector3d p_G;
  Eigen::Vector3d centre;

  Eigen::Vector3d evaluate(const SE3& T_W_B, const Eigen::Vector2d& tilt, Eigen::Matrix<double, 3, 6>* J_pose,
                           Eigen::Matrix<double, 3, 2>* J_tilt) const;
};

struct TiltedRotation {
  using Variables = graph::VariableList<SE3, graph::Vector<2>>;
  static constexpr int kDim = 3;

  SO3 R_G_B;

  Eigen::Vector3d evaluate(const SE3& T_W_B, const Eigen::Vector2d& tilt, Eigen::Matrix<double, 3, 6>* J_pose,
                           Eigen::Matrix<double, 3, 2>* J_tilt) const;
};

struct EurocEvidence {
  double tilt_deg = 0.0;
  double truth_rms_m = 0.0;  // distance of the motion's positions from the ground truth's, both as they are
  double misfit_median_m = 0.0;  // of a position from the one that 0.5 s of IMU samples lead to, 50 ms apart
  double misfit_max_m = 0.0;
  int nodes = 0;
  int iterations = 0;
};

struct EurocMotion {
  Motion motion;
  ImuRecord imu;  // the real samples within [motion.begin, motion.end], and the biases found
  EurocEvidence evidence;
};

// Smooths the sequence from the sample at or after `from` to the last one until `until`, both within the ground truth and the IMU's record
// (InputError). Handing in more than is flown keeps what is flown away from the ends.
EurocMotion smooth_euroc(const EurocSequence& sequence, Utime from, Utime until, const EurocOptions& options);

// The part of a motion and its samples within [from, until], samples' utimes both, moved so that it begins at `begin`. The evidence stays
// that of the whole.
EurocMotion cut(const EurocMotion& whole, Utime from, Utime until, Utime begin);

// When the vehicle first is 5 cm away from where it stood.
Utime take_off(const Trajectory& truth);

}  // namespace covey::sim
