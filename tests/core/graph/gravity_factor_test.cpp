// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/gravity_factor.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/graph/solve.h"
#include "tests/core/geometry/random.h"
#include "tests/core/graph/factor_testing.h"

using namespace covey;
using namespace covey::graph;
using covey::testing::kTrials;
using covey::testing::RandomGeometry;
using graph::testing::jacobian_error;

namespace {

constexpr Key kKey{'x', 0};
const Eigen::Vector3d kDown = -Eigen::Vector3d::UnitZ();

Values one(const SE3& T) {
  Values values;
  values.set(kKey, T);
  return values;
}

}  // namespace

TEST_CASE("Gravity: Jacobians agree with differences, whitened too") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 T = random.pose();
    const Eigen::Vector3d here = T.rotation.inverse() * kDown;
    const Eigen::Vector3d off = SO3::exp(random.vector<3>(0.5)) * here;
    REQUIRE(jacobian_error(GravityFactor{off}, {kKey}, one(T)) < 1e-6);
    REQUIRE(jacobian_error(GravityFactor{here}, {kKey}, one(T)) < 1e-6);
    REQUIRE(jacobian_error(GravityFactor{off}, {kKey}, one(T), Noise<2>::sigma(0.01)) < 1e-6);
    const Eigen::Vector3d west = random.vector<3>().normalized();
    REQUIRE(
        jacobian_error(GravityFactor{SO3::exp(random.vector<3>(0.5)) * (T.rotation.inverse() * west), west},
                       {kKey}, one(T)) < 1e-6);
  }
}

TEST_CASE("Gravity: the residual's length is the angle, and yaw and place do not matter") {
  RandomGeometry random;
  for (int k = 0; k < kTrials; ++k) {
    const SE3 T = random.pose();
    const double angle = random.uniform(0.0, 3.0);
    const Eigen::Vector3d down_K = T.rotation.inverse() * kDown;
    const Eigen::Vector3d axis = down_K.cross(random.vector<3>()).normalized();
    const GravityFactor factor{SO3::exp(angle * axis) * down_K};
    const Eigen::Vector2d r = factor.evaluate(T, nullptr);
    REQUIRE(r.norm() == Approx(angle).margin(1e-9));
    const SE3 moved = SE3{SO3::exp({0.0, 0.0, random.uniform(-3.0, 3.0)}), random.vector<3>()} * T;
    REQUIRE((factor.evaluate(moved, nullptr) - r).norm() < 1e-9);
  }
}

TEST_CASE("Gravity: a pose that is upside down has no residual that means anything") {
  Eigen::Matrix<double, 2, 6> J;
  REQUIRE(GravityFactor{-kDown}.evaluate({}, &J).norm() == 0.0);
  REQUIRE(J.norm() == 0.0);
}

TEST_CASE("Gravity: measured alone it turns a pose upright and leaves its place") {
  RandomGeometry random;
  for (int k = 0; k < 50; ++k) {
    const SE3 T{SO3::exp(random.vector<3>(0.7)), random.vector<3>()};
    Graph graph;
    graph.add(GravityFactor{SO3::exp(random.vector<3>(0.5)) * (T.rotation.inverse() * kDown)}, {kKey},
              Noise<2>::sigma(0.01));
    Values values = one(T);
    REQUIRE(solve(graph, values).final_cost < 1e-6);
    const SE3 turned = values.get<SE3>(kKey);
    REQUIRE((turned.translation - T.translation).norm() < 1e-9);
  }
}
