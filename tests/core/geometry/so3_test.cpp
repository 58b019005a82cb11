// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/so3.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include "tests/core/geometry/random.h"

using namespace covey;
using testing::kTrials;

namespace {

double distance(const SO3& a, const SO3& b) { return (a.matrix() - b.matrix()).norm(); }

}  // namespace

TEST_CASE("SO3: exp and log undo each other, also at 0 and near pi") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Eigen::Vector3d phi = random.rotation_vector();
    const SO3 R = SO3::exp(phi);
    REQUIRE((R.log() - phi).norm() < 1e-9);
    REQUIRE(R.log().norm() == Approx(phi.norm()).epsilon(1e-13).margin(1e-300));
    REQUIRE(distance(SO3::exp(R.log()), R) < 1e-13);
    REQUIRE(distance(SO3::exp(-phi), R.inverse()) < 1e-14);
    REQUIRE(distance(SO3::from_quaternion(Eigen::Quaterniond(-R.quaternion().coeffs())), R) < 1e-14);
  }
}

TEST_CASE("SO3: at exactly pi the logarithm is one of the two opposite vectors") {
  const SO3 R = SO3::from_quaternion({0.0, 1.0, 0.0, 0.0});
  REQUIRE(R.log().norm() == Approx(std::numbers::pi));
  REQUIRE(distance(SO3::exp(R.log()), R) < 1e-14);
  REQUIRE(SO3().log().norm() == 0.0);
}

TEST_CASE("SO3: exp is the matrix exponential of hat, and hat is the cross product") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Eigen::Vector3d phi = random.rotation_vector();
    const Eigen::Vector3d v = random.vector<3>();
    REQUIRE((SO3::exp(phi).matrix() - Eigen::Matrix3d(hat(phi).exp())).norm() < 1e-13);
    REQUIRE((hat(phi) * v - phi.cross(v)).norm() < 1e-14);
    REQUIRE(vee(hat(phi)) == phi);
  }
}

TEST_CASE("SO3: composition and action are those of the matrices") {
  testing::RandomGeometry random;
  SO3 product;
  for (int k = 0; k < kTrials; ++k) {
    const SO3 a = random.rotation();
    const SO3 b = random.rotation();
    const Eigen::Vector3d v = random.vector<3>();
    REQUIRE(((a * b).matrix() - a.matrix() * b.matrix()).norm() < 1e-14);
    REQUIRE((a * v - a.matrix() * v).norm() < 1e-14);
    REQUIRE(distance(a * a.inverse(), SO3()) < 1e-14);
    REQUIRE(a.canonical_quaternion().w() >= 0.0);
    product = product * a * b;
  }
  REQUIRE(std::abs(product.quaternion().norm() - 1.0) < 1e-14);
}

TEST_CASE("SO3: the adjoint moves a perturbation from right to left") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SO3 R = random.rotation();
    const Eigen::Vector3d phi = random.rotation_vector();
    REQUIRE(distance(R * SO3::exp(phi) * R.inverse(), SO3::exp(R.adjoint() * phi)) < 1e-14);
  }
}

TEST_CASE("SO3: Jacobians agree with differences and with each other") {
  testing::RandomGeometry random;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < kTrials; ++k) {
    const Eigen::Vector3d phi = random.rotation_vector();
    const SO3 R = SO3::exp(phi);
    const Eigen::Matrix3d left = SO3::left_jacobian(phi);
    const Eigen::Matrix3d right = SO3::right_jacobian(phi);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(c);
      const Eigen::Vector3d left_numeric =
          ((SO3::exp(phi + d) * R.inverse()).log() - (SO3::exp(phi - d) * R.inverse()).log()) / (2.0 * kStep);
      const Eigen::Vector3d right_numeric =
          ((R.inverse() * SO3::exp(phi + d)).log() - (R.inverse() * SO3::exp(phi - d)).log()) / (2.0 * kStep);
      REQUIRE((left.col(c) - left_numeric).norm() < 1e-9);
      REQUIRE((right.col(c) - right_numeric).norm() < 1e-9);
    }
    REQUIRE((left - right.transpose()).norm() < 1e-14);
    REQUIRE((left - R.matrix() * right).norm() < 1e-13);
    REQUIRE((left * SO3::left_jacobian_inverse(phi)).isIdentity(1e-12));
    REQUIRE((right * SO3::right_jacobian_inverse(phi)).isIdentity(1e-12));
  }
}

TEST_CASE("SO3: from_matrix returns the nearest rotation") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SO3 R = random.rotation();
    REQUIRE(distance(SO3::from_matrix(R.matrix()), R) < 1e-14);
    const Eigen::Matrix3d noisy =
        R.matrix() + Eigen::Matrix3d::NullaryExpr([&] { return 0.1 * random.normal(); });
    const SO3 nearest = SO3::from_matrix(noisy);
    const SO3 other = nearest * SO3::exp(random.vector<3>(0.01));
    REQUIRE((nearest.matrix() - noisy).norm() <= (other.matrix() - noisy).norm());
  }
  REQUIRE(SO3::from_matrix(-Eigen::Matrix3d::Identity()).matrix().determinant() == Approx(1.0));
}

TEST_CASE("SO3: interpolation is at constant rate") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SO3 a = random.rotation();
    const SO3 b = random.rotation();
    REQUIRE(distance(interpolate(a, b, 0.0), a) < 1e-14);
    REQUIRE(distance(interpolate(a, b, 1.0), b) < 1e-13);
    const SO3 half = interpolate(a, b, 0.5);
    REQUIRE(distance(a.inverse() * half, half.inverse() * b) < 1e-13);
  }
}
