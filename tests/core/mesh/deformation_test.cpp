// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/deformation.h"

#include <catch2/catch.hpp>

#include "core/mesh/deformation_factors.h"
#include "tests/core/geometry/random.h"
#include "tests/core/graph/factor_testing.h"
#include "tests/core/mesh/corridor.h"

using namespace covey;
using namespace covey::mesh;
using covey::testing::Corridor;

namespace {

std::vector<Eigen::Vector3f> deformed(const Corridor& corridor, const DeformationOptions& options = {}) {
  Deformation deformation(corridor.mesh, corridor.keyframes, options);
  deformation.solve();
  return deformation.move(corridor.mesh);
}

DeformationOptions room() { return {.simplify = {.min_cell_m = 0.5}}; }

}  // namespace

TEST_CASE("the factors' Jacobians are those of differences") {
  testing::RandomGeometry random;
  for (int trial = 0; trial < 100; ++trial) {
    graph::Values values;
    values.set({'m', 0}, random.pose());
    values.set({'m', 1}, random.pose());
    const RigidTie tie{random.vector<3>(2.0)};
    REQUIRE(graph::testing::jacobian_error(tie, {{'m', 0}, {'m', 1}}, values) < 1e-6);
    const SO3 near = values.get<SE3>({'m', 0}).rotation * SO3::exp(random.vector<3>(0.5));
    REQUIRE(graph::testing::jacobian_error(RotationPrior{near}, {{'m', 0}}, values) < 1e-6);
  }
}

TEST_CASE("a corridor that drift has bent comes back") {
  const Corridor corridor = testing::make_corridor(testing::bend);
  const testing::Distances before = testing::distances(corridor.mesh.p_O, corridor.p_W);
  REQUIRE(before.max_m > 2.0);
  Deformation deformation(corridor.mesh, corridor.keyframes, room());
  const testing::Distances start = testing::distances(deformation.move(corridor.mesh), corridor.p_W);
  deformation.solve();
  const testing::Distances after = testing::distances(deformation.move(corridor.mesh), corridor.p_W);
  INFO("mean " << after.mean_m << " m, max " << after.max_m << " m; at the start " << start.mean_m << " m");
  REQUIRE(after.mean_m < 0.0015);
  REQUIRE(after.max_m < 0.010);
  REQUIRE(after.mean_m < 0.5 * start.mean_m);
}

TEST_CASE("vertices stay where they are when no keyframe has moved") {
  const Corridor corridor = testing::make_corridor([](double) { return SE3{}; });
  REQUIRE(testing::distances(deformed(corridor), corridor.p_W).max_m < 1e-5);
}

TEST_CASE("a rigid motion of all keyframes is exact, whatever it is") {
  testing::RandomGeometry random(5);
  const Corridor measured = testing::make_corridor(testing::bend, {.length_m = 8.0});
  for (int trial = 0; trial < 3; ++trial) {
    const SE3 T = random.pose();
    Corridor corridor = measured;
    for (PlacedKeyframe& keyframe : corridor.keyframes) keyframe.T_W_K = T * keyframe.T_O_K;
    for (std::size_t v = 0; v < corridor.p_W.size(); ++v) {
      corridor.p_W[v] = (T * corridor.mesh.p_O[v].cast<double>()).cast<float>();
    }
    REQUIRE(testing::distances(deformed(corridor), corridor.p_W).max_m < 2e-5);
  }
}

TEST_CASE("a second passage follows its own keyframes, not those of the first") {
  const auto drift = [](double seconds) {
    return SE3{SO3{}, {0.0, seconds < 30.0 ? 0.0 : 0.4, seconds < 30.0 ? 0.0 : 0.2}};
  };
  Corridor corridor = testing::make_corridor(drift, {.length_m = 10.0});
  testing::add_passage(corridor, drift, {.length_m = 10.0, .start_s = 40.0});
  const testing::Distances after = testing::distances(deformed(corridor, room()), corridor.p_W);
  REQUIRE(after.max_m < 1e-3);
  // Without the parting the two pull at the same nodes.
  DeformationOptions mixed = room();
  mixed.simplify.pass_us = from_seconds(1000.0);
  REQUIRE(testing::distances(deformed(corridor, mixed), corridor.p_W).mean_m > 0.05);
}

TEST_CASE("each segment goes to its own place") {
  testing::RandomGeometry random(8);
  const SE3 T_W_O = random.pose();
  Corridor corridor = testing::make_corridor(testing::bend, {.length_m = 10.0});
  testing::add_passage(corridor, [&](double) { return T_W_O.inverse(); },
                       {.length_m = 10.0, .start_s = 11.0, .segment = 8});
  REQUIRE(testing::distances(deformed(corridor, room()), corridor.p_W).max_m < 0.012);
}

TEST_CASE("the cost falls, in a few steps, and stepping is solving") {
  const Corridor corridor = testing::make_corridor(testing::bend);
  Deformation deformation(corridor.mesh, corridor.keyframes, room());
  while (deformation.step()) continue;
  REQUIRE(deformation.result().converged);
  REQUIRE(deformation.result().iterations <= 6);
  REQUIRE(deformation.result().final_cost < 0.8 * deformation.result().initial_cost);
  REQUIRE_FALSE(deformation.step());
}

TEST_CASE("a mesh of nothing, of one vertex, of one triangle") {
  const Corridor corridor = testing::make_corridor(testing::bend, {.length_m = 1.0});
  Deformation nothing({}, {});
  nothing.solve();
  REQUIRE(nothing.move(MeasuredMesh{}).empty());
  MeasuredMesh one;
  one.p_O = {corridor.mesh.p_O[0]};
  one.seen_by = {corridor.mesh.seen_by[0]};
  Deformation of_one(one, corridor.keyframes);
  of_one.solve();
  REQUIRE((of_one.move(one)[0] - corridor.p_W[0]).norm() < 1e-5F);
  MeasuredMesh triangle;
  for (const int v : {0, 1, 2}) {
    triangle.p_O.push_back(corridor.mesh.p_O[v]);
    triangle.seen_by.push_back(corridor.mesh.seen_by[v]);
  }
  triangle.faces = {{0, 1, 2}};
  Deformation of_triangle(triangle, corridor.keyframes);
  of_triangle.solve();
  for (const int v : {0, 1, 2}) REQUIRE((of_triangle.move(triangle)[v] - corridor.p_W[v]).norm() < 1e-4F);
}
