// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/start.h"

#include <catch2/catch.hpp>

#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "worlds.h"

using namespace covey;
using namespace covey::pgo;

namespace {

double largest_error(const Poses& poses, const Poses& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    largest = std::max(largest, (poses[i].translation - truth[i].translation).norm());
  }
  return largest;
}

constexpr double kTiny = 1e-9;

}  // namespace

TEST_CASE("without noise every start is the truth") {
  for (const int dimension : {2, 3}) {
    const Walk walk =
        make_walk({.dimension = dimension, .rotation_sigma = kTiny, .translation_sigma = kTiny});
    CHECK(largest_error(odometry_start(walk.graph), walk.truth) < 1e-4);
    CHECK(largest_error(chordal_start(walk.graph), walk.truth) < 1e-5);
    const PoseGraph team = cut_into_robots(walk.graph, 4);
    CHECK(largest_error(robust_start(team).poses, walk.truth) < 1e-4);
    CHECK(largest_error(naive_start(team, 3), walk.truth) < 1e-4);
  }
}

TEST_CASE("the chordal start is close to the optimum where odometry is far from it") {
  for (const int dimension : {2, 3}) {
    const Walk walk = make_walk({.dimension = dimension, .poses = 400, .rotation_sigma = 0.05});
    const double at_truth = cost(walk.graph, walk.truth);
    CHECK(cost(walk.graph, chordal_start(walk.graph)) < 1.5 * at_truth);
    CHECK(cost(walk.graph, odometry_start(walk.graph)) > 10.0 * at_truth);
  }
}

TEST_CASE("a broken odometry chain is bridged by loops, else begins again") {
  PoseGraph graph{3, {4}, {}};
  const SE3 step{SO3{}, {1, 0, 0}};
  graph.edges = {{{0, 0}, {0, 1}, step, 1, 1, EdgeKind::kOdometry, true},
                 {{0, 2}, {0, 3}, step, 1, 1, EdgeKind::kOdometry, true},
                 {{0, 3}, {0, 0}, {SO3{}, {-5, 0, 0}}, 1, 1, EdgeKind::kLoop, false}};
  CHECK(odometry_start(graph)[2].translation.x() == Approx(4.0));
  graph.edges.pop_back();
  CHECK(odometry_start(graph)[2].translation.x() == 0.0);
  CHECK(odometry_start(graph)[3].translation.x() == 1.0);
}

TEST_CASE("the robust start puts a team together among outliers, the naive one does not") {
  const Walk walk = make_walk({.poses = 300, .rotation_sigma = 0.002, .translation_sigma = 0.01});
  const PoseGraph team = inject_outliers(cut_into_robots(walk.graph, 3), 0.7, 11).graph;
  const RobustStart start = robust_start(team);
  CHECK(start.alignments.size() == 3);
  CHECK(start.frames.edges.size() == 2);
  CHECK(largest_error(start.poses, walk.truth) < 1.0);
  CHECK(largest_error(naive_start(team, 1), walk.truth) > 2.0);
}

TEST_CASE("a robot without loops to the others keeps its own frame") {
  const PoseGraph team{3, {1, 0, 1, 1}, {{{2, 0}, {3, 0}, SE3{}, 1, 1, EdgeKind::kLoop, false}}};
  const RobustStart start = robust_start(team);
  CHECK(start.frames.T_W_O[0]);
  CHECK(!start.frames.T_W_O[2]);
}
