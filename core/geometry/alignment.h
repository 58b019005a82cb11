// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The rigid motion (optionally with scale) that takes one set of points onto another in the least-squares
// sense:
//
//   minimise  sum_k | to_k - (s R from_k + t) |^2   over R in SO(3), t, and s (1 unless asked for)
//
// When every z is exactly 0 the motion is planar, and unique from two points on. Otherwise fewer than three
// points, or points on a line, leave a rotation free and one of the minimisers is returned. Source: Umeyama,
// "Least-squares estimation of transformation parameters between two point patterns", PAMI 1991.

#include <Eigen/Core>
#include <vector>

#include "core/geometry/se3.h"

namespace covey {

struct Alignment {
  SE3 T_to_from;
  double scale = 1.0;
  double rms =
      0.0;  // of the distances after alignment, in the unit of the points; this is the ATE of a trajectory

  Eigen::Vector3d operator*(const Eigen::Vector3d& p_from) const {
    return T_to_from.rotation * Eigen::Vector3d(scale * p_from) + T_to_from.translation;
  }
};

// Both of the same length, at least one point.
Alignment align_points(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to,
                       bool with_scale = false);

}  // namespace covey
