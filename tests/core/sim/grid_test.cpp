// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/grid.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"
#include "core/eval/loops.h"

namespace covey::sim {
namespace {

double squared_residual(const pgo::Edge& edge, const GridWorld& world) {
  const SE3& T_W_from = world.truth[edge.from.robot][edge.from.index].pose;
  const SE3& T_W_to = world.truth[edge.to.robot][edge.to.index].pose;
  const SE3 error = edge.measurement.inverse() * T_W_from.inverse() * T_W_to;
  const Eigen::Matrix3d R = error.rotation.matrix() - Eigen::Matrix3d::Identity();
  return edge.kappa * R.squaredNorm() + edge.tau * error.translation.squaredNorm();
}

bool same(const GridWorld& a, const GridWorld& b) {
  if (a.graph.edges.size() != b.graph.edges.size()) return false;
  for (std::size_t e = 0; e < a.graph.edges.size(); ++e) {
    if ((a.graph.edges[e].measurement.inverse() * b.graph.edges[e].measurement).log().norm() > 0.0)
      return false;
  }
  return true;
}

TEST_CASE("a world repeats with its seed and differs with another") {
  const GridWorld world = make_grid({});
  CHECK(same(world, make_grid({})));
  CHECK_FALSE(same(world, make_grid({.seed = 2})));
}

TEST_CASE("drives are redrawn until the robots meet, and a drive too short for that is refused") {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6})
    CHECK_NOTHROW(make_grid({.keyframes = 30, .seed = seed}));
  CHECK_THROWS_AS(make_grid({.robots = 6, .keyframes = 4}), InputError);
}

TEST_CASE("keyframes are stamped once a second and driven at the speed of the options") {
  const GridOptions options;
  const GridWorld world = make_grid(options);
  REQUIRE(world.truth.size() == 3);
  for (const Trajectory& truth : world.truth) {
    REQUIRE(static_cast<int>(truth.size()) == options.keyframes);
    for (std::size_t k = 1; k < truth.size(); ++k) {
      CHECK(truth[k].utime - truth[k - 1].utime == kUsPerSecond);
      const double step = (truth[k].pose.translation - truth[k - 1].pose.translation).head<2>().norm();
      CHECK(step == Approx(options.step_m));
    }
  }
}

TEST_CASE("odometry and right closures have the noise that their precisions claim") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const GridWorld world = make_grid({.seed = seed});
    double odometry = 0.0;
    double closures = 0.0;
    int n_odometry = 0;
    int n_closures = 0;
    for (std::size_t e = 0; e < world.graph.edges.size(); ++e) {
      const pgo::Edge& edge = world.graph.edges[e];
      if (!world.right[e]) continue;
      const bool is_odometry = edge.kind == pgo::EdgeKind::kOdometry;
      (is_odometry ? odometry : closures) += squared_residual(edge, world);
      ++(is_odometry ? n_odometry : n_closures);
    }
    REQUIRE(n_odometry == 3 * 119);
    REQUIRE(n_closures > 60);
    // Means of chi-square variables with 6 degrees of freedom: 6 +- 3.5 / sqrt(n).
    CHECK(odometry / n_odometry == Approx(6.0).margin(4 * 3.5 / std::sqrt(n_odometry)));
    CHECK(closures / n_closures == Approx(6.0).margin(4 * 3.5 / std::sqrt(n_closures)));
  }
}

TEST_CASE("a third of the closures is false, and truth tells them apart") {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const GridWorld world = make_grid({.seed = seed});
    std::vector<JudgedClosure> closures;
    for (std::size_t e = 0; e < world.graph.edges.size(); ++e) {
      const pgo::Edge& edge = world.graph.edges[e];
      if (edge.kind == pgo::EdgeKind::kOdometry) continue;
      const SE3& T_W_A = world.truth[edge.from.robot][edge.from.index].pose;
      const SE3& T_W_B = world.truth[edge.to.robot][edge.to.index].pose;
      CHECK(is_right_closure(edge.measurement, T_W_A.inverse() * T_W_B) == world.right[e]);
      closures.push_back({edge.from.robot, edge.to.robot, true, world.right[e]});
    }
    const LoopScore score = score_loops(closures, 3);
    CHECK(score.precision.value() == Approx(2.0 / 3.0).margin(0.01));
  }
}

}  // namespace
}  // namespace covey::sim
