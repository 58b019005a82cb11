// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/frame_tree.h"

#include <catch2/catch.hpp>

using namespace covey;
using namespace covey::pgo;

namespace {

SE3 at(double x, double y, double yaw) { return {SO3::exp({0.0, 0.0, yaw}), {x, y, 0.0}}; }

PairAlignment alignment(int a, int b, const SE3& T_A_B, int inliers, int total) {
  PairAlignment pair{a, b, {}};
  pair.alignment.T_A_B = T_A_B;
  pair.alignment.inliers = inliers;
  pair.alignment.total = total;
  pair.alignment.ok = true;
  return pair;
}

}  // namespace

TEST_CASE("the tree follows the alignments with the most inliers and composes them") {
  std::vector<SE3> T_W_O;
  for (int robot = 0; robot < 5; ++robot)
    T_W_O.push_back(at(30.0 * robot, -5.0 * robot * robot, 0.7 * robot));
  std::vector<PairAlignment> pairs;
  const auto add = [&](int a, int b, int inliers, bool right) {
    PairAlignment pair{a, b, {}};
    pair.alignment.T_A_B = right ? T_W_O[a].inverse() * T_W_O[b] : at(50.0, 0.0, 1.0);
    pair.alignment.inliers = inliers;
    pair.alignment.ok = inliers >= 2;
    pairs.push_back(pair);
  };
  add(0, 1, 5, false);
  add(0, 2, 10, true);
  add(1, 2, 8, true);  // reached against its direction
  add(3, 1, 6, true);
  add(0, 4, 1, false);  // not ok: robot 4 stays out
  const Frames frames = spanning_tree(pairs, std::vector<FrameExtent>(5));
  for (int robot = 0; robot < 4; ++robot) {
    REQUIRE(frames.T_W_O[robot]);
    CHECK((frames.T_W_O[robot]->inverse() * T_W_O[robot]).log().norm() < 1e-12);
  }
  CHECK(!frames.T_W_O[4]);
  CHECK(frames.edges == std::vector<std::pair<int, int>>{{0, 2}, {2, 1}, {1, 3}});
}

// Robots that drive along one street one after the other: the third comes back to where the first was, the second never meets
// them but at its ends. Three of thirty wrong loops of the first two happen to agree.
TEST_CASE("loops that confirm each other around a cycle outweigh more of them that stand alone") {
  const SE3 T_0_1 = at(300.0, 0.0, 0.0);
  const SE3 T_0_2 = at(0.0, 20.0, 3.0);
  const SE3 drift = at(3.0, -2.0, 0.02);
  std::vector<PairAlignment> pairs = {alignment(0, 2, T_0_2, 40, 50)};
  pairs.push_back(alignment(0, 1, at(-100.0, 0.0, 0.0), 3, 30));
  for (int k = 0; k < 13; ++k) pairs.push_back(alignment(0, 1, at(-200.0 + 7.0 * k, 1.0, 0.0), 2, 30));
  pairs.push_back(alignment(0, 1, T_0_1, 1, 30));
  pairs.push_back(alignment(1, 2, at(-50.0, 100.0, 2.0), 1, 2));
  pairs.push_back(alignment(1, 2, T_0_1.inverse() * drift * T_0_2, 1, 2));
  const std::vector<FrameExtent> extents(3, {{100.0, 0.0, 0.0}, 200.0});
  const Frames frames = spanning_tree(pairs, extents);
  REQUIRE(frames.T_W_O[1]);
  CHECK((frames.T_W_O[1]->translation - T_0_1.translation).norm() < 10.0);

  SECTION("but many that agree decide alone") {
    pairs[1].alignment.inliers = 15;
    CHECK(spanning_tree(pairs, extents).T_W_O[1]->translation.x() == Approx(-100.0));
  }
  SECTION("and none confirm each other further apart than odometry drifts") {
    pairs.back().alignment.T_A_B.translation.x() += 60.0;
    CHECK((spanning_tree(pairs, extents).T_W_O[1]->translation - T_0_1.translation).norm() > 10.0);
  }
}

// Drift spreads right loops over many places near each other, which makes agreement look like chance, and keeps other pairs from
// confirming them.
TEST_CASE("a place that is by itself likelier than chance does not give way") {
  const std::vector<FrameExtent> extents(3, {{100.0, 0.0, 0.0}, 200.0});
  const auto x_of_second = [&](int inliers) {
    std::vector<PairAlignment> pairs = {alignment(0, 2, at(0.0, 20.0, 3.0), 40, 50)};
    pairs.push_back(alignment(0, 1, at(-100.0, 0.0, 0.0), inliers, 100));
    for (int k = 0; k < 13; ++k) pairs.push_back(alignment(0, 1, at(-200.0 + 7.0 * k, 1.0, 0.0), 4, 100));
    pairs.push_back(alignment(1, 2, at(-50.0, 100.0, 2.0), 3, 3));
    return spanning_tree(pairs, extents).T_W_O[1]->translation.x();
  };
  CHECK(x_of_second(12) == Approx(-100.0));
  CHECK(x_of_second(8) > 100.0);
}
