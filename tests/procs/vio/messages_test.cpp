// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/messages.h"

#include <catch2/catch.hpp>
#include <limits>

using namespace covey;

TEST_CASE("states and keyframes of vio become messages, numbers in their places") {
  vio::VioState state{};
  state.utime = 5;
  state.segment = 3;
  state.state.T_W_B = {SO3::exp({0.1, 0.2, -0.3}), {1.0, 2.0, 3.0}};
  state.state.v_W = {4.0, 5.0, 6.0};
  state.state.bias = {{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}};
  state.covariance(0, 8) = 0.5;
  state.coasting = true;
  const state_t message = to_message(state, 2);
  CHECK(message.utime == 5);
  CHECK(message.robot == 2);
  CHECK(message.segment == 3);
  CHECK(message.t_O_B[1] == 2.0);
  CHECK(message.q_O_B[0] == Approx(state.state.T_W_B.rotation.canonical_quaternion().w()));
  CHECK(message.q_O_B[3] == Approx(state.state.T_W_B.rotation.canonical_quaternion().z()));
  CHECK(message.v_O[2] == 6.0);
  CHECK(message.gyro_bias[0] == 0.1);
  CHECK(message.accel_bias[2] == 0.6);
  CHECK(message.covariance[8] == 0.5F);
  CHECK(message.coasting == 1);

  vio::VioKeyframe keyframe{};
  keyframe.utime = 9;
  keyframe.segment = 3;
  keyframe.id = 4;
  keyframe.T_O_K.translation = {1.0, 0.0, 0.0};
  keyframe.T_P_K.translation = {0.0, 1.0, 0.0};
  keyframe.covariance(1, 5) = 0.25;
  keyframe.gravity_K = {0.0, -1.0, 0.0};
  keyframe.gravity_sigma_rad = 0.01;
  const keyframe_t cut = to_message(keyframe, 2);
  CHECK(cut.id == 4);
  CHECK(cut.t_O_K[0] == 1.0);
  CHECK(cut.t_P_K[1] == 1.0);
  CHECK(cut.covariance[11] == 0.25);
  CHECK(cut.gravity_K[1] == -1.0);
  CHECK(cut.gravity_sigma_rad == 0.01);
}

TEST_CASE("odometry with values that are no poses is refused") {
  odometry_t message{};
  CHECK_FALSE(odometry_from(message));  // the quaternion is zero
  message.q_O_B[0] = 2.0;
  message.t_O_B[2] = 7.0;
  message.covariance[1] = 0.5;
  CHECK_FALSE(odometry_from(message));  // a keyframe without variance is one that no pose graph takes
  for (int k = 0; k < 6; ++k) message.covariance[7 * k] = 1.0;
  const auto pose = odometry_from(message);
  REQUIRE(pose);
  CHECK(pose->T_O_B.translation.z() == 7.0);
  CHECK(pose->T_O_B.rotation.log().norm() == 0.0);
  CHECK(pose->covariance(0, 1) == 0.5);
  message.covariance[35] = -1.0;
  CHECK_FALSE(odometry_from(message));
  message.covariance[35] = 1.0;
  message.t_O_B[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(odometry_from(message));
}
