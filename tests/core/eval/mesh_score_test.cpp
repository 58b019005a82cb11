// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/mesh_score.h"

#include <catch2/catch.hpp>

#include "core/eval/seen_surface.h"
#include "core/eval/surface_icp.h"
#include "tests/core/eval/planes.h"
#include "tests/core/geometry/random.h"

using namespace covey;
using covey::testing::joined;
using covey::testing::make_plane;

namespace {

testing::Place floor_at(double z) {
  return [z](double u, double v) { return Eigen::Vector3d(u, v, z); };
}

viewer::Mesh floor_of_squares(double z = 0.0) { return make_plane(4.0, 3.0, 0.1, floor_at(z)); }

MeshScore score(const viewer::Mesh& estimate, const viewer::Mesh& reference) {
  const Surface truth(reference);
  return score_mesh(Surface(estimate), truth, truth.sample(1000.0), 1.0);
}

}  // namespace

TEST_CASE("Surface: samples lie evenly on the mesh, and are the same each time") {
  const Surface surface(
      joined(make_plane(4.0, 3.0, 0.5, floor_at(0.0)), make_plane(2.0, 1.0, 0.01, floor_at(1.0))));
  REQUIRE(surface.area_m2() == Approx(14.0));
  const auto samples = surface.sample(500.0);
  REQUIRE(samples.size() == 7000);
  const auto above =
      std::count_if(samples.begin(), samples.end(), [](const auto& s) { return s.p.z() > 0.5F; });
  REQUIRE(above == 1000);
  const auto left = std::count_if(samples.begin(), samples.end(),
                                  [](const auto& s) { return s.p.z() < 0.5F && s.p.x() < 2.0F; });
  REQUIRE(std::abs(left - 3000) < 100);
  const auto again = surface.sample(500.0);
  for (std::size_t k = 0; k < samples.size(); ++k) REQUIRE(samples[k].p == again[k].p);
}

TEST_CASE("Surface: near the mesh, the nearest point is that of a search through all triangles") {
  testing::RandomGeometry random(4);
  viewer::Mesh mesh;
  for (std::uint32_t k = 0; k < 300; ++k) {
    const Eigen::Vector3d p = random.vector<3>(2.0);
    for (int c = 0; c < 3; ++c) mesh.vertices.push_back((p + random.vector<3>(0.3)).cast<float>());
    mesh.faces.push_back({3 * k, 3 * k + 1, 3 * k + 2});
  }
  const Surface surface(mesh);
  int same = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto& corners = mesh.faces[random.index(300)];
    const Eigen::Vector3f inside =
        (mesh.vertices[corners[0]] + mesh.vertices[corners[1]] + mesh.vertices[corners[2]]) / 3;
    const Eigen::Vector3f p = inside + random.vector<3>(0.05).cast<float>();
    // Densely sampled triangles, one by one.
    double best = 1e9;
    for (const auto& [a, b, c] : mesh.faces) {
      for (int i = 0; i <= 20; ++i) {
        for (int j = 0; i + j <= 20; ++j) {
          const Eigen::Vector3f q = mesh.vertices[a] + 0.05F * i * (mesh.vertices[b] - mesh.vertices[a]) +
                                    0.05F * j * (mesh.vertices[c] - mesh.vertices[a]);
          best = std::min(best, static_cast<double>((p - q).norm()));
        }
      }
    }
    const double distance = surface.nearest(p).distance_m;
    REQUIRE(distance > best - 0.03);
    if (distance < best + 1e-5) ++same;
  }
  REQUIRE(same > 294);
}

TEST_CASE("a mesh against itself is perfect, and a shifted plane is wrong by its shift") {
  const MeshScore same = score(floor_of_squares(), floor_of_squares());
  REQUIRE(same.error.mean_m < 1e-5);
  REQUIRE(same.completeness.mean_m < 1e-5);
  REQUIRE(same.labels == 1.0);
  const MeshScore shifted = score(floor_of_squares(0.07), floor_of_squares());
  REQUIRE(shifted.error.mean_m == Approx(0.07).margin(1e-5));
  REQUIRE(shifted.error.median_m == Approx(0.07).margin(1e-5));
  REQUIRE(shifted.error.rms_m == Approx(0.07).margin(1e-5));
  REQUIRE(shifted.completeness.mean_m == Approx(0.07).margin(1e-5));
  REQUIRE(shifted.error.within[0] == 0.0);
  REQUIRE(shifted.error.within[1] == Approx(1.0));
  REQUIRE(shifted.error.samples == 12000);
}

TEST_CASE("the figures do not depend on how the surfaces are cut into triangles or sampled") {
  const viewer::Mesh coarse = make_plane(4.0, 3.0, 1.0, floor_at(0.0));
  const MeshScore fine = score(floor_of_squares(0.03), coarse);
  REQUIRE(fine.error.mean_m == Approx(0.03).margin(1e-5));
  const Surface truth(coarse);
  const MeshScoreOptions few = {.most_samples = 50};
  REQUIRE(samples_per_m2(truth, few) == Approx(50.0 / 12.0));
  const MeshScore thin = score_mesh(Surface(floor_of_squares(0.03)), truth, truth.sample(4.0), 1.0, few);
  REQUIRE(thin.error.samples == 50);
  REQUIRE(thin.error.mean_m == Approx(0.03).margin(1e-5));
  REQUIRE(thin.completeness.mean_m == Approx(0.03).margin(1e-5));
}

TEST_CASE("a missing half shows in completeness, and what is too much in the error") {
  const viewer::Mesh half = make_plane(2.0, 3.0, 0.1, floor_at(0.0));
  const MeshScore missing = score(half, floor_of_squares());
  REQUIRE(missing.error.mean_m < 1e-5);
  REQUIRE(missing.completeness.mean_m == Approx(0.5).margin(0.01));  // half of it, from 0 to 2 m away
  REQUIRE(missing.completeness.within[0] == Approx(0.5 + 0.05 / 4.0).margin(0.01));
  const MeshScore junk = score(floor_of_squares(), half);
  REQUIRE(junk.error.mean_m == Approx(0.5).margin(0.01));
  REQUIRE(junk.completeness.mean_m < 1e-5);
}

TEST_CASE("labels: swapped, missing and unknown to the reference") {
  const auto halves = [](int left, int right) {
    return make_plane(4.0, 3.0, 0.1, floor_at(0.0),
                      [=](double u, double) { return u < 1.95 ? left : right; });
  };
  REQUIRE(score(halves(1, 2), halves(1, 2)).labels == Approx(1.0).margin(0.01));
  REQUIRE(score(halves(2, 1), halves(1, 2)).labels == Approx(0.0).margin(0.01));
  REQUIRE(score(halves(1, 1), halves(1, 2)).labels == Approx(0.5).margin(0.01));
  const MeshScore unsure = score(halves(1, 255), halves(1, 2));
  REQUIRE(unsure.labels == Approx(0.5).margin(0.01));
  REQUIRE(unsure.labelled == Approx(0.5).margin(0.01));
  const MeshScore unknown = score(halves(1, 2), halves(1, 255));
  REQUIRE(unknown.labels == Approx(1.0).margin(0.01));
  REQUIRE(unknown.compared == Approx(6000).margin(100));
}

TEST_CASE("align_surface finds a small motion of a corner of three planes") {
  const auto corner =
      joined(joined(floor_of_squares(),
                    make_plane(4.0, 2.0, 0.1, [](double u, double v) { return Eigen::Vector3d(u, 0.0, v); })),
             make_plane(3.0, 2.0, 0.1, [](double u, double v) { return Eigen::Vector3d(0.0, u, v); }));
  const SE3 T{SO3::exp({0.01, -0.02, 0.03}), {0.05, -0.04, 0.06}};
  viewer::Mesh moved = corner;
  for (Eigen::Vector3f& p : moved.vertices) p = (T * p.cast<double>()).cast<float>();
  const IcpResult result =
      align_surface(Surface(moved), Surface(corner), {.max_iterations = 200, .least_motion_m = 1e-6});
  REQUIRE(result.rms_m < 0.01);
  const SE3 left = result.T_reference_estimate * T;
  REQUIRE(left.translation.norm() < 0.02);
  REQUIRE(left.rotation.log().norm() < 0.01);
}

TEST_CASE("seen_points: in front, in range and in the picture") {
  // A wall at x = 5 of 4 x 3 m, with one as large behind it at x = 6, and one at x = 14.
  const auto wall = [](double x) {
    return make_plane(4.0, 3.0, 0.5,
                      [x](double u, double v) { return Eigen::Vector3d(x, u - 2.0, v - 1.5); });
  };
  const viewer::Mesh world = joined(joined(wall(5.0), wall(6.0)), wall(14.0));
  DepthCamera camera;
  camera.camera = {.width = 188, .height = 120, .fx = 100.0, .fy = 100.0, .cx = 93.5, .cy = 59.5};
  camera.T_B_C.rotation = SO3::from_matrix((Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished());
  camera.far_m = 10.0;
  const Surface surface(world);
  const auto points = surface.sample(100.0);
  viewer::Renderer renderer;
  const auto share_seen = [&](const std::vector<bool>& seen, float x) {
    double all = 0.0;
    double marked = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (std::abs(points[k].p.x() - x) > 0.1F) continue;
      all += 1.0;
      marked += seen[k] ? 1.0 : 0.0;
    }
    return marked / all;
  };
  const Trajectory from_start = {{0, SE3{}}};
  const auto seen = seen_points(renderer, world, points, {from_start}, camera);
  REQUIRE(share_seen(seen, 5.0F) > 0.99);
  REQUIRE(share_seen(seen, 6.0F) == 0.0);
  REQUIRE(share_seen(seen, 14.0F) == 0.0);
  // From beyond the second wall the third is in range; from far to the right half of a wall is in the picture.
  const Trajectory on_the_way = {{0, SE3{}}, {1, SE3{SO3{}, {7.0, 0.0, 0.0}}}};
  REQUIRE(share_seen(seen_points(renderer, world, points, {on_the_way}, camera), 14.0F) > 0.97);
  const Trajectory aside = {{0, SE3{SO3{}, {0.0, 4.7, 0.0}}}};
  REQUIRE(share_seen(seen_points(renderer, world, points, {aside}, camera), 5.0F) ==
          Approx(0.5).margin(0.03));
  REQUIRE(share_seen(seen_points(renderer, world, points, {}, camera), 5.0F) == 0.0);
}
