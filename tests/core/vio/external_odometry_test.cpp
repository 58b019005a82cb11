// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/external_odometry.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <string>

using namespace covey;
using namespace covey::vio;

namespace {

constexpr Utime kStep = 50'000;

// 1 m/s along the body's x axis with a slow turn; begins somewhere, turned.
SE3 sender_pose(int k) {
  const SE3 start{SO3::exp({0.0, 0.0, 1.2}), {4.0, -3.0, 0.5}};
  return start * SE3{SO3::exp({0.0, 0.0, 0.01 * k}), {0.05 * k, 0.0, 0.0}};
}

OdometryPose pose_at(int k) { return {1'000'000 + k * kStep, 0, sender_pose(k), Matrix6d::Zero()}; }

}  // namespace

TEST_CASE("keyframes of somebody else's odometry begin at the origin and chain to its poses") {
  ExternalOdometry odometry({}, {});
  std::vector<VioKeyframe> keyframes;
  std::vector<VioState> states;
  for (int k = 0; k <= 60; ++k) {
    const VioFrame frame = odometry.add(pose_at(k));
    CHECK(frame.dropped == nullptr);
    states.insert(states.end(), frame.states.begin(), frame.states.end());
    keyframes.insert(keyframes.end(), frame.keyframes.begin(), frame.keyframes.end());
  }
  REQUIRE(states.size() == 61);
  const SE3 T_O_S = states.front().state.T_W_B * sender_pose(0).inverse();
  CHECK(states.front().state.T_W_B.log().norm() < 1e-12);
  for (int k = 0; k <= 60; ++k) {
    const VioState& state = states[static_cast<std::size_t>(k)];
    CHECK((state.state.T_W_B.inverse() * T_O_S * sender_pose(k)).log().norm() < 1e-9);
    CHECK(state.segment == 1'000'000);
    if (k > 0) CHECK(state.state.v_W.norm() == Approx(1.0).epsilon(0.01));
  }
  REQUIRE(keyframes.size() >= 6);  // 3 m of way
  CHECK(keyframes.front().covariance.isZero());
  SE3 chained;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    CHECK(keyframes[i].id == static_cast<int>(i));
    CHECK(keyframes[i].gravity_K.isZero());
    chained = chained * keyframes[i].T_P_K;
    CHECK((chained.inverse() * keyframes[i].T_O_K).log().norm() < 1e-9);
    if (i == 0) continue;
    CHECK(keyframes[i].T_P_K.translation.norm() < 0.61);
    const double lowest = Eigen::SelfAdjointEigenSolver<Matrix6d>(keyframes[i].covariance).eigenvalues()(0);
    CHECK(lowest > 0.0);
  }
}

TEST_CASE("covariances of steps add up along the way, seen from the newest pose") {
  ExternalOdometryOptions options;
  options.gravity_sigma_deg = 1.0;
  ExternalOdometry odometry({}, options);
  Matrix6d step_covariance = Matrix6d::Zero();
  step_covariance.diagonal() << 1e-4, 1e-4, 1e-4, 0.0, 0.0, 1e-4;
  SE3 T_P_B;
  Matrix6d expected = Matrix6d::Zero();
  for (int k = 0; k <= 20; ++k) {
    OdometryPose pose = pose_at(k);
    pose.covariance = step_covariance;
    const VioFrame frame = odometry.add(pose);
    if (k > 0) {
      const SE3 step = sender_pose(k - 1).inverse() * sender_pose(k);
      const Matrix6d Ad = step.inverse().adjoint();
      expected = Ad * expected * Ad.transpose() + step_covariance;
    }
    for (const VioKeyframe& keyframe : frame.keyframes) {
      CHECK((keyframe.gravity_K - Eigen::Vector3d(0.0, 0.0, -1.0)).norm() < 1e-12);
      CHECK(keyframe.gravity_sigma_rad == Approx(0.01745).epsilon(1e-3));
      if (keyframe.id == 0) continue;
      CHECK((keyframe.covariance - expected).norm() < 1e-12);
      expected.setZero();
    }
  }
}

TEST_CASE("another segment of the sender, or a jump, opens a segment, and what is late is dropped") {
  ExternalOdometry odometry({}, {});
  CHECK(odometry.add(pose_at(0)).keyframes.size() == 1);
  CHECK(odometry.add(pose_at(1)).keyframes.empty());
  CHECK(std::string(odometry.add(pose_at(1)).dropped) == "late");
  OdometryPose jumped = pose_at(2);
  jumped.T_O_B.translation.x() += 10.0;
  const VioFrame after_jump = odometry.add(jumped);
  REQUIRE(after_jump.keyframes.size() == 1);
  CHECK(after_jump.keyframes.front().id == 0);
  CHECK(after_jump.keyframes.front().segment == jumped.utime);
  OdometryPose renamed = jumped;
  renamed.utime += kStep;
  renamed.segment = 77;
  CHECK(odometry.add(renamed).keyframes.size() == 1);
  CHECK(odometry.add(renamed).health.segments == 0);
}

TEST_CASE("odometry whose clock went back begins a segment, but a few late poses are only late") {
  ExternalOdometry odometry({}, {});
  for (int k = 1000; k <= 1010; ++k) CHECK(odometry.add(pose_at(k)).dropped == nullptr);
  for (int k = 1000; k < 1010; ++k) CHECK(odometry.add(pose_at(k)).dropped == std::string("late"));
  CHECK(odometry.add(pose_at(1011)).health.segments == 1);
  int taken = 0;
  VioFrame frame;
  for (int k = 0; k < 100; ++k) {
    frame = odometry.add(pose_at(k));
    if (frame.dropped == nullptr) ++taken;
  }
  CHECK(taken == 80);
  CHECK(frame.health.segments == 2);
}
