// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/front_end.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"
#include "core/pgo/trajectories.h"
#include "core/sim/grid.h"

namespace covey::sim {
namespace {

using pgo::keyframe_utime;

SE3 pose_of(const double (&q)[4], const double (&t)[3]) {
  return {SO3::from_quaternion({q[0], q[1], q[2], q[3]}), {t[0], t[1], t[2]}};
}

TEST_CASE("a robot says all its keyframes and every loop that it takes part in, numbered without gaps") {
  const GridWorld world = make_grid({.keyframes = 60});
  for (int robot = 0; robot < 3; ++robot) {
    int keyframes = 0;
    int loops = 0;
    Utime last = 0;
    for (const FrontEndMessage& message : front_end_messages(world.graph, robot)) {
      CHECK(utime_of(message) >= last);
      last = utime_of(message);
      if (const auto* keyframe = std::get_if<keyframe_t>(&message)) {
        CHECK(keyframe->id == keyframes++);
        CHECK(keyframe->robot == robot);
        CHECK(keyframe->segment == keyframe_utime(0));
        continue;
      }
      const auto& loop = std::get<loop_t>(message);
      CHECK(loop.number == loops++);
      CHECK((loop.robot_a == robot || loop.robot_b == robot));
      // The robot's own ends have been said before.
      CHECK((loop.robot_a != robot || loop.id_a < keyframes));
      CHECK((loop.robot_b != robot || loop.id_b < keyframes));
    }
    int expected = 0;
    for (const pgo::Edge& edge : world.graph.edges) {
      const bool own = edge.from.robot == robot || edge.to.robot == robot;
      expected += own && edge.kind == pgo::EdgeKind::kLoop ? 1 : 0;
    }
    CHECK(keyframes == 60);
    CHECK(loops == expected);
  }
}

TEST_CASE("poses chain the odometry, and covariances give kappa and tau back") {
  const GridWorld world = make_grid({.keyframes = 60});
  SE3 T_O_K;
  for (const FrontEndMessage& message : front_end_messages(world.graph, 1)) {
    const auto* keyframe = std::get_if<keyframe_t>(&message);
    if (keyframe == nullptr) continue;
    T_O_K = T_O_K * pose_of(keyframe->q_P_K, keyframe->t_P_K);
    CHECK((T_O_K.inverse() * pose_of(keyframe->q_O_K, keyframe->t_O_K)).log().norm() < 1e-9);
    if (keyframe->id == 0) continue;
    const Eigen::Map<const Matrix6d> covariance(keyframe->covariance);
    const double tau = 3.0 / covariance.topLeftCorner<3, 3>().trace();
    const double kappa = 3.0 / (2.0 * covariance.bottomRightCorner<3, 3>().trace());
    CHECK(tau == Approx(world.graph.edges[0].tau));
    CHECK(kappa == Approx(world.graph.edges[0].kappa));
  }
}

TEST_CASE("a robot without poses and odometry with a hole are refused") {
  GridWorld world = make_grid({.keyframes = 30});
  CHECK_THROWS_AS(front_end_messages(world.graph, 3), InputError);
  CHECK_THROWS_AS(front_end_messages(world.graph, -1), InputError);
  world.graph.edges.erase(world.graph.edges.begin() + 7);
  CHECK_THROWS_WITH(front_end_messages(world.graph, 0), Catch::Matchers::Contains("from pose 7 to pose 8"));
  CHECK_NOTHROW(front_end_messages(world.graph, 1));
}

}  // namespace
}  // namespace covey::sim
