// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/graph_score.h"

#include <catch2/catch.hpp>

#include "core/pgo/trajectories.h"
#include "core/sim/grid.h"

namespace covey {
namespace {

constexpr double kBarc2 = 25.0;

TEST_CASE("at the truth of the grid nearly all right closures are kept, and no false one") {
  const sim::GridWorld world = sim::make_grid({.keyframes = 60});
  const pgo::Poses truth = pgo::from_trajectories(world.graph, world.truth);
  const GraphScore score = score_graph(world.graph, {truth, std::nullopt}, kBarc2, truth);
  CHECK(score.loops.precision.value() == 1.0);
  CHECK(score.loops.recall.value() > 0.95);
  CHECK(score.loops.sum.total == world.graph.loops());
  CHECK(score.robust.kept_loops == score.loops.sum.kept);
}

TEST_CASE("weights decide where they are given, and the cost does not look at them") {
  const sim::GridWorld world = sim::make_grid({.keyframes = 60});
  const pgo::Poses truth = pgo::from_trajectories(world.graph, world.truth);
  const GraphScore by_residual = score_graph(world.graph, {truth, std::nullopt}, kBarc2, truth);
  const std::vector<bool> none(world.graph.edges.size(), false);
  const GraphScore by_weight = score_graph(world.graph, {truth, none}, kBarc2, truth);
  CHECK(by_weight.loops.sum.kept == 0);
  CHECK_FALSE(by_weight.loops.precision);
  CHECK(by_weight.loops.recall.value() == 0.0);
  CHECK(by_weight.robust.cost == by_residual.robust.cost);
  CHECK_FALSE(score_graph(world.graph, {truth, std::nullopt}, kBarc2).loops.precision);
}

}  // namespace
}  // namespace covey
