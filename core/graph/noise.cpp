// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/noise.h"

#include <Eigen/Eigenvalues>

namespace covey::graph::internal {
namespace {

Eigen::MatrixXd with_eigenvalues(const Eigen::MatrixXd& V, const Eigen::VectorXd& values) {
  return V * values.asDiagonal() * V.transpose();
}

}  // namespace

Eigen::MatrixXd root_of_information(const Eigen::MatrixXd& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  return with_eigenvalues(eigen.eigenvectors(), eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt());
}

Eigen::MatrixXd root_of_inverse(const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  const double floor = 1e-12 * eigen.eigenvalues().maxCoeff();
  return with_eigenvalues(eigen.eigenvectors(),
                          eigen.eigenvalues().cwiseMax(floor).cwiseSqrt().cwiseInverse());
}

}  // namespace covey::graph::internal
