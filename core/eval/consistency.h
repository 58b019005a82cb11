// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Whether odometry knows how wrong it is: normalised estimation error squared (NEES) against a reference, divided by its degrees of freedom, so that it is
// 1 in the mean where errors and covariances match; above, the estimator is too sure of itself. Source: Bar-Shalom, Li, Kirubarajan, "Estimation with
// Applications to Tracking and Navigation", 2001, section 5.4.
//
// States: e = position error and yaw error (4), both since the segment's first state, which is put where the reference was (odometry knows neither):
//
//   T_true = T_O_B Exp([rho; phi]),   e = A [rho; phi],   A = [R_O_B, 0; 0, z^T R_O_B],   NEES = e^T (A P A^T)^-1 e
//
// Edges: E = Log(T_a_b^-1 T_W_a^-1 T_W_b) (6), of chains of keyframes' relative poses that last at least some span; their covariances add up along the chain,
// P_ac = Ad(T_bc^-1) P_ab Ad(T_bc^-1)^T + P_bc, as a pose graph takes them.

#include <vector>

#include "core/geometry/trajectory.h"

namespace covey {

struct PoseBelief {
  Utime utime = 0;
  Utime segment = 0;
  SE3 T_O_B;
  Matrix6d covariance = Matrix6d::Zero();  // [rho; phi] in B
};

struct EdgeBelief {
  Utime utime = 0;  // of the later keyframe
  Utime segment = 0;
  int id = 0;  // of the later keyframe; from the one with id - 1
  SE3 T_P_K;
  Matrix6d covariance = Matrix6d::Zero();  // [rho; phi] in K
};

struct Nees {
  int count = 0;  // of errors; 0: the means mean nothing
  double mean = 0.0;
  double position = 0.0;  // of the first three components alone
  double rotation = 0.0;  // of the others; of states, yaw
};

// Both lists in order of time within a segment; what the reference does not cover is left out.
Nees state_nees(const std::vector<PoseBelief>& states, const Trajectory& reference);
// Keyframes with id 0 belong in it, with whatever pose: chains begin there. They follow one another without overlap.
Nees edge_nees(const std::vector<EdgeBelief>& edges, const Trajectory& reference, double span_s);

}  // namespace covey
