// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the covariance of a measured pose, over [rho; phi] in its second frame, counts as.
//
// Where it decides what is an outlier it has a floor: steps of odometry are correlated and verification is sure of itself, so
// that edges as they come reject right ones. With F the diagonal of the floor's sigmas,
//
//   Sigma' = F max(F^-1 Sigma F^-1, I) F,
//
// the max on the eigenvalues: at least the floor in every direction, never less than Sigma, and Sigma itself where it is above.
// Odometry may go without (floored_odometry): a solver that counts with the deciding covariances to the end, and refines nothing after
// it, would give most of what odometry knows away.
// The distributed solver counts with the isotropic precisions of CONVENTIONS.md,
//
//   tau = 3 / tr(Sigma_t),   kappa = 3 / (2 tr(Sigma_R)).

#include "core/geometry/se3.h"

namespace covey::pgo {

struct Precision {
  double kappa = 1.0;  // 1 / rad^2
  double tau = 1.0;    // 1 / m^2
};
Precision precision_of(const Matrix6d& covariance);

// A direction of gravity that a front end measured.
struct Gravity {
  Eigen::Vector3d down_K = Eigen::Vector3d::Zero();  // unit vector in the keyframe's frame
  double sigma = 0.0;                                // rad; 0: not known
};

struct NoiseOptions {
  double floor_translation_sigma = 0.03;    // m
  double floor_rotation_sigma = 0.0052360;  // rad, 0.3 deg
  bool floored_odometry = true;
  // true: all edges alike, whatever their covariances say: the paper's setting (with a threshold of probability 0.5).
  bool isotropic = false;
  double isotropic_translation_sigma = 0.1;  // m
  double isotropic_rotation_sigma = 0.01;    // rad
};
Matrix6d deciding_covariance(const Matrix6d& covariance, const NoiseOptions& options);
// Of a step of odometry.
Matrix6d deciding_odometry_covariance(const Matrix6d& covariance, const NoiseOptions& options);

// Sigma' for a floor of these sigmas.
Matrix6d with_floor(const Matrix6d& covariance, double translation_sigma, double rotation_sigma);

}  // namespace covey::pgo
