// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/robot_graph.h"

#include <catch2/catch.hpp>
#include <limits>
#include <string>

namespace covey::pgo {
namespace {

Keyframe keyframe(Utime segment, int id) {
  return {{1, segment, id}, 1000 * id, {}, {}, Matrix6d::Identity()};
}
Loop loop(KeyframeName a, KeyframeName b) { return {a, b, {}, Matrix6d::Identity()}; }

TEST_CASE("a snapshot holds what both ends of are known") {
  RobotGraph graph(1);
  for (int id = 0; id < 3; ++id) REQUIRE(graph.add(keyframe(5, id)) == nullptr);
  REQUIRE(graph.add(keyframe(9, 0)) == nullptr);
  REQUIRE(graph.add(loop({1, 5, 0}, {1, 5, 2})) == nullptr);
  REQUIRE(graph.add(loop({1, 5, 0}, {1, 9, 0})) == nullptr);
  REQUIRE(graph.add(loop({2, 7, 0}, {1, 5, 2})) == nullptr);
  REQUIRE(graph.add(loop({1, 5, 7}, {0, 7, 1})) == nullptr);  // its keyframe has not come yet
  const GraphSnapshot snapshot = graph.snapshot();
  REQUIRE(snapshot.poses() == 4);
  REQUIRE(snapshot.segments.size() == 2);
  REQUIRE(snapshot.private_loops.size() == 2);
  REQUIRE(snapshot.shared_loops.size() == 1);
  REQUIRE(snapshot.shared_loops.at(2).size() == 1);
  for (int id = 3; id < 8; ++id) graph.add(keyframe(5, id));
  REQUIRE(graph.snapshot().shared_loops.at(0).size() == 1);
  REQUIRE(graph.snapshot().hash != snapshot.hash);
}

TEST_CASE("both ends of a loop give it the same key, and order does not matter to a snapshot") {
  RobotGraph one(1);
  RobotGraph two(2);
  one.add(keyframe(5, 0));
  two.add({{2, 7, 0}, 0, {}, {}, Matrix6d::Identity()});
  for (RobotGraph* graph : {&one, &two}) REQUIRE(graph->add(loop({1, 5, 0}, {2, 7, 0})) == nullptr);
  REQUIRE(one.snapshot().shared_loops.at(2)[0].key == two.snapshot().shared_loops.at(1)[0].key);
  RobotGraph again(1);
  again.add(loop({1, 5, 0}, {2, 7, 0}));
  again.add(keyframe(5, 0));
  REQUIRE(again.snapshot().hash == one.snapshot().hash);
}

TEST_CASE("what was measured is kept, and counts as the options say") {
  Keyframe second = keyframe(5, 1);
  second.covariance.diagonal() << 1e-6, 0.04, 0.04, 1e-8, 1e-8, 1e-8;
  second.gravity = {-Eigen::Vector3d::UnitZ(), 0.02};
  Loop closure = loop({1, 5, 0}, {1, 5, 1});
  closure.covariance = second.covariance;
  const auto taken = [&](const NoiseOptions& noise) {
    RobotGraph graph(1, noise);
    REQUIRE(graph.add(keyframe(5, 0)) == nullptr);
    REQUIRE(graph.add(second) == nullptr);
    REQUIRE(graph.add(closure) == nullptr);
    return graph.snapshot();
  };
  const GraphSnapshot floored = taken({.floor_translation_sigma = 0.1, .floor_rotation_sigma = 0.01});
  const OdometryPose& pose = floored.segments[0].poses[1];
  REQUIRE(pose.precision.tau == Approx(3.0 / (0.01 + 0.04 + 0.04)));
  REQUIRE(pose.precision.kappa == Approx(0.5 / 1e-4));
  REQUIRE(pose.covariance == second.covariance);
  REQUIRE(pose.gravity.sigma == 0.02);
  REQUIRE(floored.private_loops[0].precision.tau == Approx(pose.precision.tau));
  const GraphSnapshot loops_only =
      taken({.floor_translation_sigma = 0.1, .floor_rotation_sigma = 0.01, .floored_odometry = false});
  REQUIRE(loops_only.segments[0].poses[1].precision.tau == Approx(3.0 / (1e-6 + 0.04 + 0.04)));
  REQUIRE(loops_only.private_loops[0].precision.tau == Approx(pose.precision.tau));
  const GraphSnapshot paper = taken({.isotropic = true});
  REQUIRE(paper.segments[0].poses[1].precision.tau == Approx(100.0));
  REQUIRE(paper.segments[0].poses[1].precision.kappa == Approx(5000.0));
  // Both ends of a loop know it by the same name, however they count.
  REQUIRE(paper.private_loops[0].key == floored.private_loops[0].key);
}

TEST_CASE("what cannot be used is refused with its reason") {
  RobotGraph graph(1);
  REQUIRE(graph.add(keyframe(5, 1)) == std::string("gap"));
  REQUIRE(graph.add(keyframe(5, 0)) == nullptr);
  REQUIRE(graph.add(keyframe(5, 0)) == std::string("duplicate"));
  Keyframe other = keyframe(5, 1);
  other.name.robot = 2;
  REQUIRE(graph.add(other) == std::string("robot"));
  Keyframe bad = keyframe(5, 1);
  bad.T_P_K.translation.x() = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(graph.add(bad) == std::string("values"));
  bad = keyframe(5, 1);
  bad.covariance.setZero();
  REQUIRE(graph.add(bad) == std::string("values"));
  bad.covariance.setIdentity() *= 1e-20;
  REQUIRE(graph.add(bad) == std::string("values"));
  bad = keyframe(5, 1);
  bad.T_O_K.translation.z() = -1e9;
  REQUIRE(graph.add(bad) == std::string("values"));
  bad = keyframe(5, 1);
  bad.gravity = {Eigen::Vector3d(0.0, 0.0, -2.0), 0.01};
  REQUIRE(graph.add(bad) == std::string("values"));
  REQUIRE(graph.add(loop({0, 1, 0}, {2, 1, 0})) == std::string("robot"));
  REQUIRE(graph.add(loop({1, 5, 0}, {1, 5, 0})) == std::string("values"));
  REQUIRE(graph.add(loop({1, 5, 0}, {2, 1, 0})) == nullptr);
  REQUIRE(graph.add(loop({1, 5, 0}, {2, 1, 0})) == std::string("duplicate"));
}

}  // namespace
}  // namespace covey::pgo
