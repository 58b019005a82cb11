// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A pose graph solved with the noise that its measurements say they have, instead of one kappa and one tau for each edge:
//
//   r_e = Log(T_ij^-1 T_i^-1 T_j),   cost r_e^T Sigma_e^-1 r_e
//
// In two steps. What is an outlier is decided by graduated non-convexity (core/graph/gnc.h) on the squared Mahalanobis residuals of
// covariances with a floor (edge_noise.h). Then the poses are refined with the loops that were kept: these keep the floor, and
// odometry, which cannot be rejected, gets its own covariance with a small part of it. Gravity takes part in both (core/graph/
// gravity_factor.h), with the floor's rotation: one filter made all of a robot's directions, and they err together.

#include <functional>
#include <vector>

#include "core/pgo/central.h"
#include "core/pgo/edge_noise.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct MeasuredNoise {
  std::vector<Matrix6d> covariances;  // per edge of the graph
  std::vector<Gravity> gravity;       // per pose in flat order
};

struct MeasuredOptions {
  NoiseOptions noise{};
  double barc2 = 16.812;                 // of the squared Mahalanobis residual
  double mu_step = 1.4;                  // growth of mu per round, as long as it is small
  double odometry_floor = 0.1;           // part of the floor that odometry has in the end
  std::function<void()> each_step = {};  // core/graph/solve.h
  // Flat index of the pose that stays where the start has it. Where its direction of gravity is known all directions count, the
  // start says which way they point in its frame, and the pose keeps its place and yaw alone.
  int gauge = 0;
};

struct MeasuredResult {
  CentralResult central;   // cost: known inliers r2, others min(r2, barc2)
  std::vector<double> r2;  // per edge: Mahalanobis, with the floor, at the result
};
MeasuredResult solve_measured(const PoseGraph& graph, const MeasuredNoise& noise, const Poses& start,
                              const MeasuredOptions& options);

// |Log(T_A_B^-1 T_W_A^-1 T_W_B)|^2 in the metric of the covariance.
double mahalanobis_sq(const SE3& T_A_B, const Matrix6d& covariance, const SE3& T_W_A, const SE3& T_W_B);

}  // namespace covey::pgo
