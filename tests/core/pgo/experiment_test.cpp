// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/experiment.h"

#include <catch2/catch.hpp>
#include <map>

#include "core/pgo/cost.h"
#include "worlds.h"

using namespace covey;
using namespace covey::pgo;

TEST_CASE("a graph is cut into equal contiguous ranges") {
  const Walk walk = make_walk({.poses = 200});
  const PoseGraph cut = cut_into_robots(walk.graph, 3);
  CHECK(cut.poses_per_robot == std::vector<int>{66, 67, 67});
  REQUIRE(cut.edges.size() == walk.graph.edges.size());
  const std::vector<int> offsets = cut.offsets();
  int across = 0;
  for (std::size_t e = 0; e < cut.edges.size(); ++e) {
    const Edge& before = walk.graph.edges[e];
    const Edge& after = cut.edges[e];
    REQUIRE(offsets[after.from.robot] + after.from.index == before.from.index);
    REQUIRE(offsets[after.to.robot] + after.to.index == before.to.index);
    if (after.between_robots()) {
      CHECK(after.kind == EdgeKind::kLoop);
      CHECK(!after.known_inlier);
      across += before.kind == EdgeKind::kOdometry ? 1 : 0;
    } else {
      CHECK(after.kind == before.kind);
      CHECK(after.known_inlier == before.known_inlier);
    }
  }
  CHECK(across == 2);
  CHECK(cut.loops() == walk.graph.loops() + 2);
}

TEST_CASE("outliers are as many as asked for, where and as large as defined, and the same for a seed") {
  for (const int robots : {1, 3}) {
    for (const int dimension : {2, 3}) {
      const PoseGraph graph = cut_into_robots(make_walk({.dimension = dimension}).graph, robots);
      const Injection injection = inject_outliers(graph, 0.7, 5);
      const auto added = injection.graph.edges.size() - graph.edges.size();
      CHECK(added == static_cast<std::size_t>(std::lround(graph.loops() * 7.0 / 3.0)));
      double largest = 0.0;
      for (std::size_t e = 0; e < injection.graph.edges.size(); ++e) {
        const Edge& edge = injection.graph.edges[e];
        REQUIRE(injection.is_true[e] == (e < graph.edges.size()));
        if (injection.is_true[e]) continue;
        REQUIRE(edge.kind == EdgeKind::kLoop);
        REQUIRE(!edge.known_inlier);
        REQUIRE(edge.between_robots() == (robots > 1));
        if (robots == 1) REQUIRE(std::abs(edge.from.index - edge.to.index) > 1);
        REQUIRE(edge.kappa == graph.edges.back().kappa);
        if (dimension == 2) REQUIRE(edge.measurement.translation.z() == 0.0);
        largest = std::max(largest, edge.measurement.translation.cwiseAbs().maxCoeff());
      }
      CHECK(largest <= 10.0);
      CHECK(largest > 9.5);
      const Injection same = inject_outliers(graph, 0.7, 5);
      CHECK(same.graph.edges.back().measurement.translation ==
            injection.graph.edges.back().measurement.translation);
      const Injection other = inject_outliers(graph, 0.7, 6);
      CHECK(other.graph.edges.back().measurement.translation !=
            injection.graph.edges.back().measurement.translation);
    }
  }
  CHECK(inject_outliers(make_walk({}).graph, 0.0, 1).graph.edges.size() == make_walk({}).graph.edges.size());
}

TEST_CASE("the Stata-like world has the loops that were asked for, with the noise that they claim") {
  const StataOptions options{.poses_per_robot = 800, .closures_per_robot = 60, .seed = 4};
  const StataWorld world = stata_like(options);
  const PoseGraph& graph = world.graph;
  CHECK(graph.poses_per_robot == std::vector<int>{800, 800, 800});
  REQUIRE(world.truth.size() == 2400);
  const std::vector<double> r2 = squared_residuals(graph, world.truth);
  std::map<std::pair<int, int>, int> true_loops;
  std::map<std::pair<int, int>, int> false_loops;
  double odometry = 0.0;
  double loops = 0.0;
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    if (edge.kind == EdgeKind::kOdometry) odometry += r2[e] / (3 * 799);
    if (edge.kind == EdgeKind::kOdometry) continue;
    ++(world.is_true[e] ? true_loops : false_loops)[{edge.from.robot, edge.to.robot}];
    if (world.is_true[e]) loops += r2[e] / (3 * 60 + 3);
  }
  CHECK(true_loops == std::map<std::pair<int, int>, int>{
                          {{0, 0}, 60}, {{1, 1}, 60}, {{2, 2}, 60}, {{0, 1}, 2}, {{1, 2}, 1}});
  CHECK(false_loops == std::map<std::pair<int, int>, int>{{{0, 0}, 15}, {{1, 1}, 15}, {{2, 2}, 15}});
  CHECK(odometry == Approx(6.0).epsilon(0.1));  // chi-square, 6 degrees of freedom
  CHECK(loops == Approx(6.0).epsilon(0.2));
  for (std::size_t k = 1; k < 800; ++k)
    REQUIRE((world.truth[k].translation - world.truth[k - 1].translation).norm() < 0.56);
  CHECK(stata_like(options).graph.edges.back().measurement.translation ==
        graph.edges.back().measurement.translation);
}
