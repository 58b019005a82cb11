// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pose_graph.h"

#include <catch2/catch.hpp>

using namespace covey;
using namespace covey::pgo;

TEST_CASE("flat indices count robot by robot, and parts are joined by edges") {
  PoseGraph graph{3, {2, 0, 3}, {}};
  graph.edges = {{{0, 1}, {2, 0}, {}}, {{2, 2}, {2, 1}, {}}};
  CHECK(graph.poses() == 5);
  CHECK(graph.offsets() == std::vector<int>{0, 2, 2, 5});
  CHECK(connected_parts(graph) == std::vector<int>{0, 1, 1, 2, 2});
}

TEST_CASE("poses convert to blocks of their dimension and back") {
  const SE3 planar{SO3::exp({0, 0, -2.0}), {3, 4, 0}};
  const SE3 spatial{SO3::exp({0.3, 1.0, -2.0}), {3, 4, 5}};
  CHECK(rotation_of(planar, 2).rows() == 2);
  CHECK(translation_of(planar, 2).size() == 2);
  for (const auto& [T, d] : {std::pair(planar, 2), std::pair(spatial, 3)}) {
    const SE3 back = pose_of(rotation_of(T, d), translation_of(T, d));
    CHECK((back.inverse() * T).log().norm() < 1e-14);
  }
}

TEST_CASE("the robust form halves kappa in 2D only") {
  PoseGraph graph{2, {2}, {{{0, 0}, {0, 1}, {}, 8.0, 2.0}}};
  CHECK(robust_form(graph).edges[0].kappa == 4.0);
  CHECK(robust_form(graph).edges[0].tau == 2.0);
  graph.dimension = 3;
  CHECK(robust_form(graph).edges[0].kappa == 8.0);
}
