// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The camera's motion between two frames, robustly, to tell which tracks moved as the still scene does. A point seen at m on z = 1 with inverse depth
// r = 1 / z is, up to scale, at q(r) = R m~ + r t in the second frame (m~ = [m; 1]), so its picture moves along a straight segment as r goes
// from one bound to the other. Minimised over t and a correction phi of the predicted rotation, R = Exp(phi) R0:
//
//   sum rho(|pi(q(r)) - m'|^2 / s^2) + |phi|^2 / sigma_phi^2 + |t|^2 / sigma_t^2,   rho(x) = x / (1 + x / c)   (Geman-McClure)
//
// by Gauss-Newton with weights, c falling from far to near ("graduated", Black and Rangarajan, IJCV 1996). A track is an inlier where m' is within
// `threshold` of the segment of the inverse depths that it may have: around the known one, or all from infinity to `nearest_m`.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"

namespace covey {

struct TrackFlow {
  Eigen::Vector2d from;                 // on z = 1 of the first frame
  Eigen::Vector2d to;                   // on z = 1 of the second
  std::optional<double> inverse_depth;  // 1 / m, in the first frame
};

struct FrameMotionOptions {
  double threshold = 2.0 / 458.0;     // on z = 1
  double inverse_depth_sigma = 0.01;  // 1 / m
  double nearest_m = 0.3;
  double rotation_sigma_rad = 0.01;  // of the predicted rotation
  double translation_sigma_m = 0.5;  // between two frames
  int fewest = 8;                    // tracks with depth
};

struct FrameMotion {
  SE3 T_cur_prev;
  std::vector<bool> inliers;  // of every flow
  int count = 0;              // of inliers
};

// Nothing where too few tracks have a depth or agree on a motion.
std::optional<FrameMotion> estimate_frame_motion(const std::vector<TrackFlow>& flows, const SO3& R_cur_prev,
                                                 const FrameMotionOptions& options);

}  // namespace covey
