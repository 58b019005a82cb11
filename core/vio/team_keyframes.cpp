// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/team_keyframes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include "core/base/angle.h"

namespace covey::vio {
namespace {

constexpr double kGravitySigmaFloor = 0.05 * kDegree;  // no accelerometer is mounted better

}  // namespace

bool team_keyframe_due(const VioOptions& options, const SE3& T_P_B, double age_s) {
  constexpr double kRounding = 1e-4;  // s
  return age_s > options.team_interval_s - kRounding || T_P_B.translation.norm() > options.team_distance_m ||
         T_P_B.rotation.log().norm() > options.team_angle_deg * kDegree;
}

Matrix6d relative_covariance(const VioOptions& options, const SE3& T_P_K,
                             const Eigen::Matrix<double, 12, 12>& covariance) {
  Eigen::Matrix<double, 6, 12> J;
  J << -T_P_K.inverse().adjoint(), Matrix6d::Identity();
  Matrix6d relative = J * covariance * J.transpose();
  const double sigma_rad =
      std::hypot(options.team_sigma_deg * kDegree, options.team_turn_share * T_P_K.rotation.log().norm());
  relative.diagonal().head<3>().array() += options.team_sigma_m * options.team_sigma_m;
  relative.diagonal().tail<3>().array() += sigma_rad * sigma_rad;
  return 0.5 * (relative + relative.transpose());
}

Eigen::Vector3d gravity_direction(const SE3& T_O_K) {
  return T_O_K.rotation.inverse() * Eigen::Vector3d(0.0, 0.0, -1.0);
}

double gravity_sigma(const SE3& T_O_K, const Matrix6d& covariance) {
  const Eigen::Vector3d down = gravity_direction(T_O_K);
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - down * down.transpose();
  const Eigen::Matrix3d tilt = across * covariance.bottomRightCorner<3, 3>() * across;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(tilt, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(eigen.eigenvalues().maxCoeff(), kGravitySigmaFloor * kGravitySigmaFloor));
}

}  // namespace covey::vio
