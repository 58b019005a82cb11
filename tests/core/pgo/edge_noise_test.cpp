// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/edge_noise.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "tests/core/geometry/random.h"

namespace covey::pgo {
namespace {

using covey::testing::RandomGeometry;

Matrix6d diagonal(double translation_variance, double rotation_variance) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(translation_variance), Eigen::Vector3d::Constant(rotation_variance);
  return variances.asDiagonal();
}

double smallest_eigenvalue(const Matrix6d& m) {
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(m).eigenvalues().minCoeff();
}

TEST_CASE("precisions come from covariances as CONVENTIONS.md says") {
  const Precision precision = precision_of(diagonal(0.01, 0.00005));
  REQUIRE(precision.tau == Approx(100.0));
  REQUIRE(precision.kappa == Approx(10000.0));
}

TEST_CASE("the floor lifts what is below it, in every direction, and nothing else") {
  RandomGeometry random;
  const Matrix6d floor = diagonal(0.03 * 0.03, 0.005 * 0.005);
  for (int k = 0; k < 100; ++k) {
    const Vector6d scale = floor.diagonal().cwiseSqrt() * random.uniform(0.1, 10.0);
    const Matrix6d A = Matrix6d::NullaryExpr([&] { return random.normal(); });
    const Matrix6d covariance = scale.asDiagonal() * A * A.transpose() * scale.asDiagonal();
    const Matrix6d lifted = with_floor(covariance, 0.03, 0.005);
    REQUIRE((lifted - lifted.transpose()).norm() < 1e-12);
    REQUIRE(smallest_eigenvalue(lifted - covariance) > -1e-9 * covariance.norm());
    REQUIRE(smallest_eigenvalue(lifted - floor) > -1e-9 * covariance.norm());
    const Matrix6d above = lifted + floor;
    REQUIRE(with_floor(above, 0.03, 0.005) == above);
  }
  REQUIRE((with_floor(diagonal(1e-6, 1e-8), 0.03, 0.005) - floor).norm() < 1e-12);
  REQUIRE(with_floor(diagonal(1.0, 1.0), 0.03, 0.005) == diagonal(1.0, 1.0));
}

TEST_CASE("the paper's setting counts every edge alike") {
  const NoiseOptions paper{.isotropic = true};
  REQUIRE(deciding_covariance(diagonal(4.0, 9.0), paper) == deciding_covariance(diagonal(1e-9, 1e-9), paper));
  REQUIRE(deciding_covariance(Matrix6d::Identity(), paper)(0, 0) == Approx(0.01));
  REQUIRE(deciding_covariance(Matrix6d::Identity(), paper)(5, 5) == Approx(1e-4));
}

}  // namespace
}  // namespace covey::pgo
