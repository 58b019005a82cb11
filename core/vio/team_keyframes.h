// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which of the smoother's keyframes become the team's, and what these say.

#include <Eigen/Eigenvalues>

#include "core/vio/options.h"
#include "core/vio/output.h"

namespace covey::vio {

// Whether a keyframe is due, `age_s` after the last one of the team from which T_P_B is the way to here.
bool team_keyframe_due(const VioOptions& options, const SE3& T_P_B, double age_s);

// The covariance of T_P_K from that of the poses of P and K, [xi_P; xi_K] (m, rad), with what the options add:
//   xi = xi_K - Ad(T_K_P) xi_P
Matrix6d relative_covariance(const VioOptions& options, const SE3& T_P_K,
                             const Eigen::Matrix<double, 12, 12>& covariance);

// Gravity's direction in K, and the larger of the standard deviations across it from the covariance of [rho; phi].
Eigen::Vector3d gravity_direction(const SE3& T_O_K);
double gravity_sigma(const SE3& T_O_K, const Matrix6d& covariance);

}  // namespace covey::vio
