// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/messages.h"

#include <catch2/catch.hpp>

namespace covey {
namespace {

TEST_CASE("keyframes and loops keep their names, poses and covariances") {
  keyframe_t keyframe{};
  keyframe.utime = 5;
  keyframe.robot = 2;
  keyframe.segment = 7;
  keyframe.id = 3;
  keyframe.q_O_K[0] = keyframe.q_P_K[0] = 1.0;
  keyframe.t_P_K[2] = 4.0;
  keyframe.covariance[1] = 0.5;  // row 0, column 1
  const auto taken = keyframe_from(keyframe);
  REQUIRE(taken);
  REQUIRE(taken->name == pgo::KeyframeName{2, 7, 3});
  REQUIRE(taken->T_P_K.translation.z() == 4.0);
  REQUIRE(taken->covariance(0, 1) == 0.5);
  REQUIRE(taken->gravity.sigma == 0.0);
  keyframe.gravity_K[1] = -1.0;
  keyframe.gravity_sigma_rad = 0.01;
  REQUIRE(keyframe_from(keyframe)->gravity.down_K.y() == -1.0);
  REQUIRE(keyframe_from(keyframe)->gravity.sigma == 0.01);
  keyframe.gravity_K[1] = 0.0;
  REQUIRE(keyframe_from(keyframe)->gravity.sigma == 0.0);  // not known
  keyframe.q_P_K[0] = 0.5;
  REQUIRE_FALSE(keyframe_from(keyframe));

  loop_t loop{};
  loop.robot_b = 1;
  loop.id_b = 9;
  loop.q_A_B[3] = -1.0;
  const auto closure = loop_from(loop);
  REQUIRE(closure);
  REQUIRE(closure->b == pgo::KeyframeName{1, 0, 9});
  loop.q_A_B[3] = 0.0;
  REQUIRE_FALSE(loop_from(loop));
}

TEST_CASE("trajectories go out in parts, without what has no place in W") {
  pgo::GraphSnapshot graph;
  graph.robot = 1;
  graph.segments = {{10, std::vector<pgo::OdometryPose>(900)}, {20, std::vector<pgo::OdometryPose>(5)}};
  for (int k = 0; k < 900; ++k) graph.segments[0].poses[k].utime = 1000 + k;
  pgo::RoundResult result;
  result.name = {3, 0};
  result.segments = {{10, true, std::vector<SE3>(900)}, {20, false, std::vector<SE3>(5)}};
  for (int k = 0; k < 900; ++k) result.segments[0].T_W_K[k].translation.x() = k;
  const auto parts = trajectory_messages(result, graph, 77);
  REQUIRE(parts.size() == 3);
  for (int part = 0; part < 3; ++part) {
    REQUIRE(parts[part].part == part);
    REQUIRE(parts[part].parts == 3);
    REQUIRE(parts[part].total_poses == 900);
    REQUIRE(parts[part].n == (part < 2 ? 400 : 100));
    REQUIRE(parts[part].T_W_K.size() == 7 * parts[part].ids.size());
  }
  REQUIRE(parts[2].ids[99] == 899);
  REQUIRE(parts[2].utimes[99] == 1899);
  REQUIRE(parts[2].T_W_K[7 * 99 + 4] == 899.0);
  REQUIRE(trajectory_of(result, graph).size() == 900);
}

}  // namespace
}  // namespace covey
