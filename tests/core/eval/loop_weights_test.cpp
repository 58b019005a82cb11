// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/loop_weights.h"

#include <catch2/catch.hpp>
#include <limits>

namespace covey {
namespace {

constexpr pgo::PoseId kA{0, 0};
constexpr pgo::PoseId kB{1, 0};
constexpr pgo::PoseId kC{1, 1};

pgo::Edge edge(pgo::PoseId from, pgo::PoseId to, pgo::EdgeKind kind = pgo::EdgeKind::kLoop) {
  pgo::Edge result;
  result.from = from;
  result.to = to;
  result.kind = kind;
  return result;
}

// An odometry edge, a pair of poses that was measured twice, and one closure by itself.
const pgo::PoseGraph kGraph{
    3, {1, 2}, {edge(kB, kC, pgo::EdgeKind::kOdometry), edge(kA, kB), edge(kA, kB), edge(kA, kC)}};
const std::vector<double> kResiduals = {0.1, 900.0, 4.0, 7.0};

using Kept = std::vector<bool>;

TEST_CASE("measurements of the same two poses are told apart by their residuals, in whatever order") {
  CHECK(kept_by_weights(kGraph, kResiduals, {{kA, kB, 1.0, 4.1}, {kA, kB, 0.0, 870.0}}) ==
        Kept{true, false, true, false});
  CHECK(kept_by_weights(kGraph, kResiduals, {{kA, kB, 0.0, 870.0}, {kA, kB, 1.0, 4.1}}) ==
        Kept{true, false, true, false});
}

TEST_CASE("a weight that only one of them has goes to the nearest") {
  CHECK(kept_by_weights(kGraph, kResiduals, {{kA, kB, 1.0, 5.0}}) == Kept{true, false, true, false});
  CHECK(kept_by_weights(kGraph, kResiduals, {{kA, kB, 1.0, 800.0}}) == Kept{true, true, false, false});
}

TEST_CASE("a closure measured once takes its weight whatever the residual") {
  CHECK(kept_by_weights(kGraph, kResiduals, {{kA, kC, 1.0, 1e6}}) == Kept{true, false, false, true});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(kept_by_weights(kGraph, kResiduals, {{kA, kC, 1.0, nan}}) == Kept{true, false, false, true});
  CHECK(kept_by_weights(kGraph, kResiduals, {{kA, kC, 0.4, 7.0}}) == Kept{true, false, false, false});
}

TEST_CASE(
    "weights of closures that the graph does not have, and of the opposite direction, count for nothing") {
  CHECK(kept_by_weights(kGraph, kResiduals, {{kC, kA, 1.0, 7.0}, {{5, 5}, {6, 6}, 1.0, 1.0}}) ==
        Kept{true, false, false, false});
}

}  // namespace
}  // namespace covey
