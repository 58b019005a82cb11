// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/projection_factor.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"
#include "tests/core/graph/factor_testing.h"
#include "tests/core/vio/tracks.h"

using namespace covey;
using namespace covey::vio;
using covey::testing::RandomGeometry;
using covey::testing::stereo_rig;
using graph::testing::jacobian_error;

namespace {

// A camera near the chart and a point before both, from 1 m to almost infinitely far.
struct Scene {
  SE3 T_O_B;
  Landmark landmark;

  explicit Scene(RandomGeometry& random, const Rig& rig) {
    T_O_B = random.pose();
    const SE3 near = SE3::exp(0.1 * random.vector<6>());
    landmark.T_O_A = T_O_B * near * rig.left.T_B_C;
    landmark.l = {random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(0.0, 1.0)};
  }
};

}  // namespace

TEST_CASE("ProjectionFactor: analytic Jacobians are the numeric ones") {
  RandomGeometry random;
  const Rig rig = stereo_rig();
  const StereoRig stereo(rig);
  for (int trial = 0; trial < 200; ++trial) {
    const Scene scene(random, rig);
    graph::Values values;
    values.set({'x', 0}, scene.T_O_B);
    values.set({'l', 0}, graph::Vector<3>(scene.landmark.l));
    const ProjectionFactor factor{trial % 2 ? stereo.T_L_B : stereo.T_R_B, scene.landmark.T_O_A, {0.1, -0.2}};
    REQUIRE(jacobian_error(factor, {{'x', 0}, {'l', 0}}, values) < 1e-6);
  }
}

TEST_CASE("ProjectionFactor: is the projection of the point, where there is one") {
  RandomGeometry random;
  const Rig rig = stereo_rig();
  const StereoRig stereo(rig);
  for (int trial = 0; trial < 200; ++trial) {
    Scene scene(random, rig);
    scene.landmark.l.z() = random.uniform(0.01, 1.0);
    const Eigen::Vector3d& l = scene.landmark.l;
    const Eigen::Vector3d p_O = scene.landmark.T_O_A * (Eigen::Vector3d(l.x(), l.y(), 1.0) / l.z());
    const Eigen::Vector3d p_C = (scene.T_O_B * rig.right->T_B_C).inverse() * p_O;
    const ProjectionFactor factor{stereo.T_R_B, scene.landmark.T_O_A, Eigen::Vector2d::Zero()};
    const Eigen::Vector2d m = factor.evaluate(scene.T_O_B, l, nullptr, nullptr);
    REQUIRE((m - p_C.head<2>() / p_C.z()).norm() < 1e-9);
  }
}

TEST_CASE("ProjectionFactor: a point behind the camera says nothing and agrees with no view") {
  const Rig rig = stereo_rig();
  const StereoRig stereo(rig);
  const Landmark landmark{rig.left.T_B_C, {0.0, 0.0, 0.5}};
  const SE3 turned{SO3::exp({0.0, 0.0, 3.0}), Eigen::Vector3d::Zero()};
  const ProjectionFactor factor{stereo.T_L_B, landmark.T_O_A, Eigen::Vector2d::Zero()};
  Eigen::Matrix<double, 2, 6> J_pose;
  Eigen::Matrix<double, 2, 3> J_landmark;
  REQUIRE(factor.evaluate(turned, landmark.l, &J_pose, &J_landmark).norm() == 0.0);
  REQUIRE(J_pose.norm() + J_landmark.norm() == 0.0);
  const TrackObservation seen{1, Eigen::Vector2d::Zero(), std::nullopt, 0.01};
  REQUIRE(agrees(stereo, {}, landmark, seen, 3.0));
  REQUIRE_FALSE(agrees(stereo, turned, landmark, seen, 3.0));
  REQUIRE_FALSE(agrees(stereo, {}, landmark, {1, {0.04, 0.0}, std::nullopt, 0.01}, 3.0));
}
