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

TEST_CASE("precisions come from covariances as CONVENTIONS.md says") {
  Vector6d variances;
  variances << 0.01, 0.01, 0.01, 0.00005, 0.00005, 0.00005;
  const Precision precision = precision_of(variances.asDiagonal());
  REQUIRE(precision.tau == Approx(100.0));
  REQUIRE(precision.kappa == Approx(10000.0));
}

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
  REQUIRE(graph.add(loop({0, 1, 0}, {2, 1, 0})) == std::string("robot"));
  REQUIRE(graph.add(loop({1, 5, 0}, {1, 5, 0})) == std::string("values"));
  REQUIRE(graph.add(loop({1, 5, 0}, {2, 1, 0})) == nullptr);
  REQUIRE(graph.add(loop({1, 5, 0}, {2, 1, 0})) == std::string("duplicate"));
}

}  // namespace
}  // namespace covey::pgo
