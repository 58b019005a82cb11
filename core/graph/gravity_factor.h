// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A measured direction of gravity against the one that a pose predicts:
//
//   u = R_W_K^T g_W,   r = theta B^T u / |B^T u|,   theta = the angle between u and the measured unit vector m
//
// with the columns of B an orthonormal basis of the plane across m. So r is u's logarithm on the sphere at m: 2 numbers, rad, |r| =
// theta. Yaw and translation have no part in it. Against the measured direction (theta = pi) the logarithm has no direction; there
// residual and Jacobian are zero.

#include "core/graph/factor.h"

namespace covey::graph {

struct GravityFactor {
  using Variables = VariableList<SE3>;
  static constexpr int kDim = 2;

  Eigen::Vector3d measured_K;              // unit vector, down
  Eigen::Vector3d down_W{0.0, 0.0, -1.0};  // unit vector

  Eigen::Vector2d evaluate(const SE3& T_W_K, Eigen::Matrix<double, 2, 6>* J) const;
};

}  // namespace covey::graph
