// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/pose_factors.h"

#include <catch2/catch.hpp>

#include "tests/core/geometry/random.h"
#include "tests/core/graph/factor_testing.h"

using namespace covey;
using namespace covey::graph;
using covey::testing::kTrials;
using covey::testing::RandomGeometry;
using graph::testing::jacobian_error;

namespace {

constexpr Key kI{'x', 0};
constexpr Key kJ{'x', 1};

template <typename T>
Values two(const T& x_i, const T& x_j) {
  Values values;
  values.set(kI, x_i);
  values.set(kJ, x_j);
  return values;
}

// A neighbour whose residual is away from the cut of the logarithm at pi, where differences mean nothing.
SE3 near(const SE3& T, RandomGeometry& random) { return T * SE3::exp(random.vector<6>(0.5)); }
SE2 near(const SE2& T, RandomGeometry& random) { return T * SE2::exp(random.vector<3>(0.5)); }
SO3 near(const SO3& R, RandomGeometry& random) { return R * SO3::exp(random.vector<3>(0.5)); }

Matrix6d random_covariance(RandomGeometry& random) {
  const Matrix6d A = Matrix6d::NullaryExpr([&] { return random.normal(); });
  return A * A.transpose() + 0.1 * Matrix6d::Identity();
}

}  // namespace

TEST_CASE("Priors: Jacobians agree with differences") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 T = random.pose();
    const SE2 S = random.planar_pose();
    const SO3 R = random.rotation();
    const Vector<9> v = random.vector<9>();
    REQUIRE(jacobian_error(Prior<SE3>{near(T, random)}, {kI}, two(T, T)) < 1e-6);
    REQUIRE(jacobian_error(Prior<SE2>{near(S, random)}, {kI}, two(S, S)) < 1e-6);
    REQUIRE(jacobian_error(Prior<SO3>{near(R, random)}, {kI}, two(R, R)) < 1e-6);
    REQUIRE(jacobian_error(Prior<Vector<9>>{random.vector<9>()}, {kI}, two(v, v)) < 1e-6);
  }
}

TEST_CASE("Between: Jacobians agree with differences, whitened too") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 T = random.pose();
    const SE3 T_ij = random.pose();
    const auto noise = Noise<6>::covariance(random_covariance(random));
    REQUIRE(jacobian_error(Between<SE3>{T_ij}, {kI, kJ}, two(T, near(T * T_ij, random)), noise) < 1e-6);
    const SE2 S = random.planar_pose();
    const SE2 X_ij = random.planar_pose();
    REQUIRE(jacobian_error(Between<SE2>{X_ij}, {kI, kJ}, two(S, near(S * X_ij, random))) < 1e-6);
    const SO3 R = random.rotation();
    const SO3 R_ij = random.rotation();
    REQUIRE(jacobian_error(Between<SO3>{R_ij}, {kI, kJ}, two(R, near(R * R_ij, random))) < 1e-6);
  }
}

TEST_CASE("Between: the residual of x_j = x_i measured Exp(xi) is xi, in frame j") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 T = random.pose();
    const SE3 measured = random.pose();
    const Vector6d xi = random.vector<6>(0.5);
    const Vector6d r = Between<SE3>{measured}.evaluate(T, T * measured * SE3::exp(xi), nullptr, nullptr);
    REQUIRE((r - xi).norm() < 1e-10);
  }
}

TEST_CASE("Chordal: the cost is that of the matrices") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const double kappa = random.uniform(0.1, 10.0);
    const double tau = random.uniform(0.1, 10.0);
    const SE3 T_i = random.pose();
    const SE3 T_j = random.pose();
    const SE3 T_ij = random.pose();
    const double cost_3 =
        ChordalBetween3{T_ij, kappa, tau}.evaluate(T_i, T_j, nullptr, nullptr).squaredNorm();
    const Eigen::Matrix3d R_i = T_i.rotation.matrix();
    const double expected_3 =
        kappa * (T_j.rotation.matrix() - R_i * T_ij.rotation.matrix()).squaredNorm() +
        tau * (T_j.translation - T_i.translation - R_i * T_ij.translation).squaredNorm();
    REQUIRE(cost_3 == Approx(expected_3).epsilon(1e-12));

    const SE2 X_i = random.planar_pose();
    const SE2 X_j = random.planar_pose();
    const SE2 X_ij = random.planar_pose();
    const double cost_2 =
        ChordalBetween2{X_ij, kappa, tau}.evaluate(X_i, X_j, nullptr, nullptr).squaredNorm();
    const Eigen::Matrix2d Q_i = rotation_2d(X_i.angle);
    const double expected_2 =
        kappa * (rotation_2d(X_j.angle) - Q_i * rotation_2d(X_ij.angle)).squaredNorm() +
        tau * (X_j.translation - X_i.translation - Q_i * X_ij.translation).squaredNorm();
    REQUIRE(cost_2 == Approx(expected_2).epsilon(1e-12));
  }
}

TEST_CASE("Chordal: Jacobians agree with differences") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const double kappa = random.uniform(0.1, 10.0);
    const double tau = random.uniform(0.1, 10.0);
    const SE3 T = random.pose();
    const SE3 T_ij = random.pose();
    REQUIRE(jacobian_error(ChordalBetween3{T_ij, kappa, tau}, {kI, kJ}, two(T, near(T * T_ij, random))) <
            1e-6);
    const SE2 S = random.planar_pose();
    const SE2 X_ij = random.planar_pose();
    REQUIRE(jacobian_error(ChordalBetween2{X_ij, kappa, tau}, {kI, kJ}, two(S, near(S * X_ij, random))) <
            1e-6);
  }
}
