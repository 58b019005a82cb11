// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/se2.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include "tests/core/geometry/random.h"

using namespace covey;
using testing::kTrials;

namespace {

double distance(const SE2& a, const SE2& b) { return (a.matrix() - b.matrix()).norm(); }

}  // namespace

TEST_CASE("SE2: exp and log undo each other, and exp is the matrix exponential") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Eigen::Vector3d xi = random.planar_twist();
    const SE2 T = SE2::exp(xi);
    REQUIRE((T.log() - xi).norm() < 1e-12);
    REQUIRE(distance(SE2::exp(T.log()), T) < 1e-12);
    REQUIRE(distance(SE2::exp(-xi), T.inverse()) < 1e-12);
    Eigen::Matrix3d generator = Eigen::Matrix3d::Zero();
    generator.topLeftCorner<2, 2>() << 0.0, -xi.z(), xi.z(), 0.0;
    generator.topRightCorner<2, 1>() = xi.head<2>();
    REQUIRE((T.matrix() - Eigen::Matrix3d(generator.exp())).norm() < 1e-12);
  }
}

TEST_CASE("SE2: angles stay above -pi, up to pi") {
  using std::numbers::pi;
  REQUIRE(wrap_angle(pi) == pi);
  REQUIRE(wrap_angle(-pi) == pi);
  REQUIRE(wrap_angle(3.0 * pi / 2.0) == Approx(-pi / 2.0));
  REQUIRE(wrap_angle(-5.0 * pi / 2.0) == Approx(-pi / 2.0));
  SE2 pose;
  for (int k = 0; k < kTrials; ++k) {
    pose = pose * SE2{1.0, {1.0, 0.0}};
    REQUIRE(std::abs(pose.angle) <= pi);
  }
  REQUIRE((SE2{pi, {1.0, 2.0}}).inverse().angle == pi);
}

TEST_CASE("SE2: composition, action and adjoint are those of the matrices") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE2 a = random.planar_pose();
    const SE2 b = random.planar_pose();
    const Eigen::Vector2d p = random.vector<2>();
    const Eigen::Vector3d xi = random.planar_twist();
    REQUIRE(((a * b).matrix() - a.matrix() * b.matrix()).norm() < 1e-12);
    REQUIRE((a * p - (a.matrix() * p.homogeneous()).head<2>()).norm() < 1e-12);
    REQUIRE(distance(a * a.inverse(), SE2()) < 1e-12);
    REQUIRE(distance(a * SE2::exp(xi) * a.inverse(), SE2::exp(a.adjoint() * xi)) < 1e-12);
    REQUIRE((a.adjoint() * b.adjoint() - (a * b).adjoint()).norm() < 1e-12);
  }
}

TEST_CASE("SE2: Jacobians agree with differences and with each other") {
  testing::RandomGeometry random;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < kTrials; ++k) {
    const Eigen::Vector3d xi = random.planar_twist();
    const SE2 T = SE2::exp(xi);
    const Eigen::Matrix3d left = SE2::left_jacobian(xi);
    const Eigen::Matrix3d right = SE2::right_jacobian(xi);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(c);
      const Eigen::Vector3d left_numeric =
          ((SE2::exp(xi + d) * T.inverse()).log() - (SE2::exp(xi - d) * T.inverse()).log()) / (2.0 * kStep);
      const Eigen::Vector3d right_numeric =
          ((T.inverse() * SE2::exp(xi + d)).log() - (T.inverse() * SE2::exp(xi - d)).log()) / (2.0 * kStep);
      REQUIRE((left.col(c) - left_numeric).norm() < 1e-8);
      REQUIRE((right.col(c) - right_numeric).norm() < 1e-8);
    }
    REQUIRE((left - T.adjoint() * right).norm() < 1e-12);
    REQUIRE((left * SE2::left_jacobian_inverse(xi)).isIdentity(1e-12));
    REQUIRE((right * SE2::right_jacobian_inverse(xi)).isIdentity(1e-12));
  }
}

TEST_CASE("SE2: interpolation is at constant body velocity") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE2 a = random.planar_pose();
    const SE2 b = random.planar_pose();
    REQUIRE(distance(interpolate(a, b, 1.0), b) < 1e-12);
    const SE2 half = interpolate(a, b, 0.5);
    REQUIRE(distance(a.inverse() * half, half.inverse() * b) < 1e-12);
  }
}
