// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/cost.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "worlds.h"

using namespace covey;
using namespace covey::pgo;

namespace {

PoseGraph pair_graph(int dimension, double kappa, double tau) {
  return {dimension, {2}, {{{0, 0}, {0, 1}, SE3{}, kappa, tau, EdgeKind::kLoop, false}}};
}

}  // namespace

TEST_CASE("a quarter turn and a step cost what the convention says") {
  Poses poses(2);
  poses[1] = {SO3::exp({0, 0, 0.5 * std::numbers::pi}), {3, 4, 0}};
  for (const int dimension : {2, 3}) {
    // |I - R(90 deg)|_F^2 = 4 and |t|^2 = 25, in 2D and in 3D
    CHECK(cost(pair_graph(dimension, 10.0, 2.0), poses) == Approx(10.0 * 4.0 + 2.0 * 25.0));
  }
}

TEST_CASE("the cost is that of the matrices, whatever the frame") {
  const Walk walk = make_walk({});
  Poses poses = walk.truth;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i] = poses[i] * SE3::exp(0.3 * Vector6d::Constant(std::sin(static_cast<double>(i))));
  }
  double by_matrices = 0.0;
  for (const Edge& edge : walk.graph.edges) {
    const SE3& A = poses[edge.from.index];
    const SE3& B = poses[edge.to.index];
    by_matrices +=
        edge.kappa *
            (B.rotation.matrix() - A.rotation.matrix() * edge.measurement.rotation.matrix()).squaredNorm() +
        edge.tau * (B.translation - A * edge.measurement.translation).squaredNorm();
  }
  CHECK(cost(walk.graph, poses) == Approx(by_matrices).epsilon(1e-12));
  const SE3 move{SO3::exp({1, 2, -1}), {10, -20, 30}};
  for (SE3& T : poses) T = move * T;
  CHECK(cost(walk.graph, poses) == Approx(by_matrices).epsilon(1e-11));
}

TEST_CASE("the robust cost truncates loops only, and halves the turn in 2D") {
  Poses poses(3);
  poses[1] = {SO3::exp({0, 0, 0.5 * std::numbers::pi}), {0, 0, 0}};
  poses[2] = {SO3{}, {3, 0, 0}};
  for (const int dimension : {2, 3}) {
    PoseGraph graph{dimension, {3}, {}};
    graph.edges = {{{0, 0}, {0, 1}, SE3{}, 1.0, 1.0, EdgeKind::kOdometry, true},
                   {{0, 0}, {0, 2}, SE3{}, 1.0, 1.0, EdgeKind::kLoop, false},
                   {{0, 2}, {0, 0}, SE3{}, 1.0, 0.1, EdgeKind::kLoop, false}};
    const RobustCost robust = robust_cost(graph, poses, 1.0);
    CHECK(robust.cost == Approx((dimension == 2 ? 2.0 : 4.0) + 1.0 + 0.9));
    CHECK(robust.loops == 2);
    CHECK(robust.kept_loops == 1);
    CHECK(robust.kept == std::vector<bool>{true, false, true});
  }
}

TEST_CASE("precision and recall count loops only") {
  PoseGraph graph{3, {3}, std::vector<Edge>(5, Edge{{0, 0}, {0, 2}, SE3{}, 1, 1, EdgeKind::kLoop, false})};
  graph.edges[0].kind = EdgeKind::kOdometry;
  const LoopScore score =
      score_loops(graph, {true, true, true, true, false}, {true, true, false, true, true});
  CHECK(score.precision == Approx(2.0 / 3.0));
  CHECK(score.recall == Approx(2.0 / 3.0));
  CHECK(score_loops(graph, std::vector<bool>(5, false), std::vector<bool>(5, true)).precision == 1.0);
  CHECK(score_loops(graph, std::vector<bool>(5, false), std::vector<bool>(5, true)).recall == 0.0);
}
