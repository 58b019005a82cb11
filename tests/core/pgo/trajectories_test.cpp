// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/trajectories.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

PoseGraph two_robots() {
  PoseGraph graph;
  graph.poses_per_robot = {3, 0, 2};
  return graph;
}

Poses five_poses() {
  Poses poses(5);
  for (int k = 0; k < 5; ++k) poses[k].translation.x() = k;
  return poses;
}

TEST_CASE("a solution becomes trajectories and comes back, whatever else they hold") {
  std::vector<Trajectory> robots = to_trajectories(two_robots(), five_poses());
  REQUIRE(robots.size() == 3);
  CHECK(robots[0].back().utime == 3'000'000);
  CHECK(robots[1].empty());
  CHECK(robots[2].front().pose.translation.x() == 3.0);
  robots[0].insert(robots[0].begin() + 1, StampedPose{1'500'000, {}});
  const Poses poses = from_trajectories(two_robots(), robots);
  REQUIRE(poses.size() == 5);
  for (int k = 0; k < 5; ++k) CHECK(poses[k].translation.x() == k);
}

TEST_CASE("a pose without a stamp is named") {
  std::vector<Trajectory> robots = to_trajectories(two_robots(), five_poses());
  robots[2].pop_back();
  CHECK_THROWS_WITH(from_trajectories(two_robots(), robots),
                    Catch::Matchers::Contains("robot 2: the trajectory has no pose at 2"));
}

}  // namespace
}  // namespace covey::pgo
