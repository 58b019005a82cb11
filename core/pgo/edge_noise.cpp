// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/edge_noise.h"

#include <Eigen/Eigenvalues>

namespace covey::pgo {
namespace {

Vector6d sigmas(double translation, double rotation) {
  Vector6d sigmas;
  sigmas << Eigen::Vector3d::Constant(translation), Eigen::Vector3d::Constant(rotation);
  return sigmas;
}

}  // namespace

Precision precision_of(const Matrix6d& covariance) {
  return {1.5 / covariance.bottomRightCorner<3, 3>().trace(), 3.0 / covariance.topLeftCorner<3, 3>().trace()};
}

Matrix6d deciding_covariance(const Matrix6d& covariance, const NoiseOptions& options) {
  if (options.isotropic) {
    return sigmas(options.isotropic_translation_sigma, options.isotropic_rotation_sigma)
        .cwiseAbs2()
        .asDiagonal();
  }
  return with_floor(covariance, options.floor_translation_sigma, options.floor_rotation_sigma);
}

Matrix6d deciding_odometry_covariance(const Matrix6d& covariance, const NoiseOptions& options) {
  return options.isotropic || options.floored_odometry ? deciding_covariance(covariance, options)
                                                       : covariance;
}

Matrix6d with_floor(const Matrix6d& covariance, double translation_sigma, double rotation_sigma) {
  if (translation_sigma <= 0.0 || rotation_sigma <= 0.0) return covariance;
  const Vector6d floor = sigmas(translation_sigma, rotation_sigma);
  const Vector6d inverse = floor.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(inverse.asDiagonal() * covariance *
                                                      inverse.asDiagonal());
  const Vector6d& lambda = eigen.eigenvalues();
  if (lambda.minCoeff() >= 1.0) return covariance;
  const Matrix6d V = floor.asDiagonal() * eigen.eigenvectors();
  return V * lambda.cwiseMax(1.0).asDiagonal() * V.transpose();
}

}  // namespace covey::pgo
