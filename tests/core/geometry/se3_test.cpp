// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/se3.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include "tests/core/geometry/random.h"

using namespace covey;
using testing::kTrials;

namespace {

double distance(const SE3& a, const SE3& b) { return (a.matrix() - b.matrix()).norm(); }

}  // namespace

TEST_CASE("SE3: exp and log undo each other, also at 0 and near pi") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Vector6d xi = random.twist();
    const SE3 T = SE3::exp(xi);
    REQUIRE((T.log() - xi).norm() < 1e-8);
    REQUIRE(distance(SE3::exp(T.log()), T) < 1e-12);
    REQUIRE(distance(SE3::exp(-xi), T.inverse()) < 1e-12);
  }
  REQUIRE(SE3().log().norm() == 0.0);
}

TEST_CASE("SE3: exp is the matrix exponential") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Vector6d xi = random.twist();
    Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
    generator.topLeftCorner<3, 3>() = hat(xi.tail<3>());
    generator.topRightCorner<3, 1>() = xi.head<3>();
    REQUIRE((SE3::exp(xi).matrix() - Eigen::Matrix4d(generator.exp())).norm() < 1e-12);
  }
}

TEST_CASE("SE3: composition and action are those of the matrices") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 a = random.pose();
    const SE3 b = random.pose();
    const Eigen::Vector3d p = random.vector<3>();
    REQUIRE(((a * b).matrix() - a.matrix() * b.matrix()).norm() < 1e-13);
    REQUIRE((a * p - (a.matrix() * p.homogeneous()).head<3>()).norm() < 1e-13);
    REQUIRE(distance(a * a.inverse(), SE3()) < 1e-14);
    REQUIRE(distance(SE3::from_matrix(a.matrix()), a) < 1e-14);
  }
}

TEST_CASE("SE3: the adjoint moves a perturbation from right to left, and through an inverse") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 T = random.pose();
    const SE3 U = random.pose();
    const Vector6d xi = random.twist();
    REQUIRE(distance(T * SE3::exp(xi) * T.inverse(), SE3::exp(T.adjoint() * xi)) < 1e-12);
    REQUIRE((T.adjoint() * U.adjoint() - (T * U).adjoint()).norm() < 1e-12);
    REQUIRE(distance((T * SE3::exp(xi)).inverse(), T.inverse() * SE3::exp(-T.adjoint() * xi)) < 1e-11);
  }
}

TEST_CASE("SE3: Jacobians agree with differences and with each other") {
  testing::RandomGeometry random;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < kTrials; ++k) {
    const Vector6d xi = random.twist();
    const SE3 T = SE3::exp(xi);
    const Matrix6d left = SE3::left_jacobian(xi);
    const Matrix6d right = SE3::right_jacobian(xi);
    for (int c = 0; c < 6; ++c) {
      const Vector6d d = kStep * Vector6d::Unit(c);
      const Vector6d left_numeric =
          ((SE3::exp(xi + d) * T.inverse()).log() - (SE3::exp(xi - d) * T.inverse()).log()) / (2.0 * kStep);
      const Vector6d right_numeric =
          ((T.inverse() * SE3::exp(xi + d)).log() - (T.inverse() * SE3::exp(xi - d)).log()) / (2.0 * kStep);
      REQUIRE((left.col(c) - left_numeric).norm() < 1e-8);
      REQUIRE((right.col(c) - right_numeric).norm() < 1e-8);
    }
    REQUIRE((left - T.adjoint() * right).norm() < 1e-11);
    REQUIRE((left * SE3::left_jacobian_inverse(xi)).isIdentity(1e-11));
    REQUIRE((right * SE3::right_jacobian_inverse(xi)).isIdentity(1e-11));
  }
}

TEST_CASE("SE3: interpolation is at constant body velocity") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 a = random.pose();
    const SE3 b = random.pose();
    REQUIRE(distance(interpolate(a, b, 0.0), a) < 1e-13);
    REQUIRE(distance(interpolate(a, b, 1.0), b) < 1e-12);
    const SE3 half = interpolate(a, b, 0.5);
    REQUIRE(distance(a.inverse() * half, half.inverse() * b) < 1e-11);
  }
}
