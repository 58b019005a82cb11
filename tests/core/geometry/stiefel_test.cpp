// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/stiefel.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>

#include "tests/core/geometry/random.h"

using namespace covey;
using testing::kTrials;

namespace {

struct Shape {
  int r = 0;
  int d = 0;
};

Shape shape(int trial) {
  constexpr Shape kShapes[] = {{5, 3}, {5, 2}, {3, 3}, {2, 2}, {3, 2}};
  return kShapes[trial % std::size(kShapes)];
}

bool on_manifold(const Eigen::MatrixXd& Y) { return (Y.transpose() * Y).isIdentity(1e-12); }

Eigen::MatrixXd random_matrix(testing::RandomGeometry& random, Shape s) {
  return Eigen::MatrixXd::NullaryExpr(s.r, s.d, [&] { return random.normal(); });
}

}  // namespace

TEST_CASE("Stiefel: random elements, projections and retractions are on the manifold") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Shape s = shape(k);
    const Eigen::MatrixXd Y = random_stiefel(s.r, s.d, random.engine());
    const Eigen::MatrixXd V = project_to_tangent(Y, random_matrix(random, s));
    REQUIRE(on_manifold(Y));
    REQUIRE(on_manifold(project_to_stiefel(Y + 0.5 * random_matrix(random, s))));
    REQUIRE(on_manifold(retract_polar(Y, V)));
    REQUIRE(on_manifold(retract_qr(Y, V)));
    REQUIRE((project_to_stiefel(Y) - Y).norm() < 1e-12);
  }
}

TEST_CASE("Stiefel: tangent projection is orthogonal and idempotent") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Shape s = shape(k);
    const Eigen::MatrixXd Y = random_stiefel(s.r, s.d, random.engine());
    const Eigen::MatrixXd V = random_matrix(random, s);
    const Eigen::MatrixXd P = project_to_tangent(Y, V);
    const Eigen::MatrixXd inner = Y.transpose() * P;
    REQUIRE((inner + inner.transpose()).norm() < 1e-12);
    REQUIRE((project_to_tangent(Y, P) - P).norm() < 1e-12);
    REQUIRE(std::abs((V - P).cwiseProduct(P).sum()) < 1e-12);
  }
}

TEST_CASE("Stiefel: retractions are Y + V to first order") {
  testing::RandomGeometry random;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < kTrials; ++k) {
    const Shape s = shape(k);
    const Eigen::MatrixXd Y = random_stiefel(s.r, s.d, random.engine());
    const Eigen::MatrixXd V = project_to_tangent(Y, random_matrix(random, s));
    REQUIRE(((retract_polar(Y, kStep * V) - Y) / kStep - V).norm() < 1e-4);
    REQUIRE(((retract_qr(Y, kStep * V) - Y) / kStep - V).norm() < 1e-4);
    REQUIRE((retract_polar(Y, 0.0 * V) - Y).norm() < 1e-12);
  }
}

TEST_CASE("Stiefel: the projection is the nearest point") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Shape s = shape(k);
    const Eigen::MatrixXd Y = random_stiefel(s.r, s.d, random.engine());
    const Eigen::MatrixXd noisy = Y + 0.2 * random_matrix(random, s);
    const Eigen::MatrixXd nearest = project_to_stiefel(noisy);
    const Eigen::MatrixXd other =
        retract_polar(nearest, 0.01 * project_to_tangent(nearest, random_matrix(random, s)));
    REQUIRE((nearest - noisy).norm() <= (other - noisy).norm());
  }
}

TEST_CASE("Stiefel: rounding is free of the gauge and returns rotations") {
  testing::RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const Eigen::MatrixXd Q = random_stiefel(5, 3, random.engine());
    const Eigen::Matrix3d anchor = random.rotation().matrix();
    const Eigen::Matrix3d R = random.rotation().matrix();
    REQUIRE((round_lifted(Q * R, Q * anchor) - anchor.transpose() * R).norm() < 1e-12);
    const Eigen::MatrixXd unrelated = round_lifted(random_stiefel(5, 3, random.engine()), Q);
    REQUIRE(on_manifold(unrelated));
    REQUIRE(unrelated.determinant() == Approx(1.0));
  }
}
