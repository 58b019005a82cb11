// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The Stiefel manifold St(r, d): r x d matrices Y with orthonormal columns, Y^T Y = I, r >= d. Rotations of
// dimension d lifted to rank r live here; St(d, d) is O(d). With sym(A) = (A + A^T) / 2:
//
//   tangent space at Y: { V : sym(Y^T V) = 0 },   its orthogonal projection: V - Y sym(Y^T V)
//   retract(Y, V) is on the manifold and equals Y + V to first order in V
//   project(Y) is the nearest point in the Frobenius norm: U W^T of the thin SVD Y = U S W^T
//   round_lifted(Q R_i, Q R_a) = R_a^T R_i for any Q in St(r, d): the gauge Q cancels
//
// Source: Absil, Mahony, Sepulchre, "Optimization Algorithms on Matrix Manifolds", 2008, sections 3.5.7
// and 4.1.1; rounding: Rosen et al., "SE-Sync", IJRR 2019, algorithm 2.

#include <Eigen/Core>
#include <random>

namespace covey {

Eigen::MatrixXd project_to_stiefel(const Eigen::MatrixXd& Y);
Eigen::MatrixXd project_to_tangent(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& V);
Eigen::MatrixXd retract_polar(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& V);
// By QR, with the diagonal of R positive: cheaper than polar, and second-order only in the canonical metric.
Eigen::MatrixXd retract_qr(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& V);
// Uniform on St(r, d).
Eigen::MatrixXd random_stiefel(int r, int d, std::mt19937_64& random);

// The rotation (determinant +1) nearest to a d x d matrix in the Frobenius norm.
Eigen::MatrixXd project_to_rotation(const Eigen::MatrixXd& m);
// The d x d rotation of a lifted Y (r x d) relative to a lifted anchor (r x d).
Eigen::MatrixXd round_lifted(const Eigen::MatrixXd& Y, const Eigen::MatrixXd& anchor);

}  // namespace covey
