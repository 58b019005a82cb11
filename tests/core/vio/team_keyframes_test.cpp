// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/team_keyframes.h"

#include <catch2/catch.hpp>
#include <numbers>

#include "tests/core/geometry/random.h"

using namespace covey;
using namespace covey::vio;
using covey::testing::RandomGeometry;

TEST_CASE("team_keyframe_due: by distance, by angle or by time") {
  const VioOptions options;
  const double degree = std::numbers::pi / 180.0;
  REQUIRE_FALSE(team_keyframe_due(options, {}, 0.9));
  REQUIRE(team_keyframe_due(options, {}, 1.0));
  REQUIRE_FALSE(team_keyframe_due(options, {SO3{}, {0.3, 0.3, 0.2}}, 0.5));
  REQUIRE(team_keyframe_due(options, {SO3{}, {0.4, 0.3, 0.2}}, 0.5));
  REQUIRE_FALSE(team_keyframe_due(options, {SO3::exp({0.0, 14.0 * degree, 0.0}), {0, 0, 0}}, 0.5));
  REQUIRE(team_keyframe_due(options, {SO3::exp({0.0, 16.0 * degree, 0.0}), {0, 0, 0}}, 0.5));
}

TEST_CASE("relative_covariance: is that of disturbed poses, plus the floor") {
  RandomGeometry random(5);
  const SE3 T_O_P = random.pose();
  const SE3 T_O_K = T_O_P * SE3{SO3::exp({0.1, -0.2, 0.15}), {0.4, 0.2, -0.1}};
  const SE3 T_P_K = T_O_P.inverse() * T_O_K;
  Eigen::Matrix<double, 12, 12> root =
      Eigen::Matrix<double, 12, 12>::NullaryExpr([&] { return 1e-3 * random.normal(); });
  const Eigen::Matrix<double, 12, 12> covariance = root * root.transpose();
  constexpr int kSamples = 20000;
  Matrix6d sum = Matrix6d::Zero();
  for (int k = 0; k < kSamples; ++k) {
    const Eigen::Matrix<double, 12, 1> xi = root * random.vector<12>();
    const SE3 relative = (T_O_P * SE3::exp(xi.head<6>())).inverse() * (T_O_K * SE3::exp(xi.tail<6>()));
    const Vector6d e = (T_P_K.inverse() * relative).log();
    sum += e * e.transpose();
  }
  VioOptions options;
  options.team_sigma_m = options.team_sigma_deg = options.team_turn_share = 0.0;
  const Matrix6d predicted = relative_covariance(options, T_P_K, covariance);
  REQUIRE((sum / kSamples - predicted).norm() < 0.05 * predicted.norm());
  options.team_sigma_m = 0.01;
  options.team_sigma_deg = 1.0;
  const Matrix6d floor = relative_covariance(options, T_P_K, Eigen::Matrix<double, 12, 12>::Zero());
  REQUIRE(floor(2, 2) == Approx(1e-4));
  REQUIRE(floor(5, 5) == Approx(std::pow(std::numbers::pi / 180.0, 2)));
  options.team_turn_share = 0.1;
  const double turn = T_P_K.rotation.log().norm();
  const Matrix6d with_share = relative_covariance(options, T_P_K, Eigen::Matrix<double, 12, 12>::Zero());
  REQUIRE(with_share(2, 2) == Approx(1e-4));
  REQUIRE(with_share(5, 5) - floor(5, 5) == Approx(0.01 * turn * turn));
}

TEST_CASE("gravity_sigma: turns about the vertical do not count, tilt does, and there is a floor") {
  RandomGeometry random(6);
  const SE3 T_O_K = random.pose();
  const Eigen::Vector3d down = gravity_direction(T_O_K);
  REQUIRE((T_O_K.rotation * down - Eigen::Vector3d(0, 0, -1)).norm() < 1e-12);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.bottomRightCorner<3, 3>() = down * down.transpose();
  REQUIRE(gravity_sigma(T_O_K, covariance) == Approx(0.05 * std::numbers::pi / 180.0));
  const Eigen::Vector3d side = down.cross(Eigen::Vector3d::UnitX()).normalized();
  covariance.bottomRightCorner<3, 3>() += 0.04 * side * side.transpose();
  REQUIRE(gravity_sigma(T_O_K, covariance) == Approx(0.2));
}
