// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/renderer.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "shared_renderer.h"

namespace covey::viewer {
namespace {

constexpr Rgb kRed = {200, 10, 20};
constexpr Rgb kGreen = {10, 180, 30};
constexpr Rgb kWhite = {255, 255, 255};

Mesh triangle(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c, Rgb colour,
              std::uint16_t label) {
  Mesh mesh;
  mesh.vertices = {a, b, c};
  mesh.colours.assign(3, colour);
  mesh.labels.assign(3, label);
  mesh.faces = {{0, 1, 2}};
  return mesh;
}

// Looks along z_W; x right, y down.
Camera pinhole() {
  Camera camera;
  camera.fx = 80.0;
  camera.fy = 80.0;
  camera.cx = 49.5;
  camera.cy = 39.5;
  camera.width = 100;
  camera.height = 80;
  camera.far = 50.0;
  return camera;
}

std::size_t at(const Camera& camera, int u, int v) { return static_cast<std::size_t>(v * camera.width + u); }

TEST_CASE("a triangle colours the pixels that it covers, and no other") {
  Scene scene(shared_renderer().context());
  // Its corners' pixels, by u = 80 x / z + 49.5 at z = 2: (9.5, 9.5), (89.5, 9.5), (9.5, 69.5).
  scene.add(triangle({-1.0F, -0.75F, 2.0F}, {1.0F, -0.75F, 2.0F}, {-1.0F, 0.75F, 2.0F}, kRed, 5));
  for (const int samples : {1, 4}) {
    const Image image = shared_renderer().render(scene, pinhole(), {.samples = samples}).image;
    CHECK(image.at(12, 12) == kRed);
    CHECK(image.at(10, 10) == kRed);
    CHECK(image.at(9, 40) == kWhite);
    CHECK(image.at(40, 9) == kWhite);
    CHECK(image.at(10, 65) == kRed);
    CHECK(image.at(84, 10) == kRed);
    CHECK(image.at(60, 60) == kWhite);
  }
}

TEST_CASE("depth and labels are exact at the pixels' centres, on a slanted face too") {
  Scene scene(shared_renderer().context());
  // The plane z = 3 + 0.5 x + 0.25 y.
  const auto on_plane = [](float x, float y) { return Eigen::Vector3f(x, y, 3.0F + 0.5F * x + 0.25F * y); };
  scene.add(triangle(on_plane(-4, -4), on_plane(6, -4), on_plane(-4, 6), kRed, 7));
  const Camera camera = pinhole();
  const Rendering view =
      shared_renderer().render(scene, camera, {.colour = false, .depth = true, .labels = true});
  CHECK(view.image.rgb.empty());
  REQUIRE(view.depth.size() == 8000);
  for (int v = 5; v < 75; v += 7) {
    for (int u = 5; u < 60; u += 5) {
      const double x = (u - camera.cx) / camera.fx;
      const double y = (v - camera.cy) / camera.fy;
      const double depth = 3.0 / (1.0 - 0.5 * x - 0.25 * y);
      if (x * depth + y * depth > 1.9) continue;  // beyond the hypotenuse
      CHECK(view.depth[at(camera, u, v)] == Approx(depth).epsilon(2e-6));
      CHECK(view.labels[at(camera, u, v)] == 7);
    }
  }
}

TEST_CASE("where nothing is, depth is 0 and the label is kNoLabel, the nearer face hides the farther") {
  Scene scene(shared_renderer().context());
  scene.add(triangle({-9, -9, 4}, {0, -9, 4}, {0, 9, 4}, kRed, 1));
  scene.add(triangle({-9, -9, 6}, {0, -9, 6}, {0, 9, 6}, kGreen, 2));
  const Camera camera = pinhole();
  const Rendering view = shared_renderer().render(scene, camera, {.depth = true, .labels = true});
  CHECK(view.image.at(45, 20) == kRed);
  CHECK(view.depth[at(camera, 45, 20)] == Approx(4.0));
  CHECK(view.labels[at(camera, 45, 20)] == 1);
  CHECK(view.image.at(60, 20) == kWhite);
  CHECK(view.depth[at(camera, 60, 20)] == 0.0F);
  CHECK(view.labels[at(camera, 60, 20)] == kNoLabel);
}

TEST_CASE("a rendered corner lies within 0.05 pixels of its projection") {
  // The ridge of a roof, z = 4 + |x| beneath it, seen in depth: the two slopes meet where the ridge projects to. Likewise
  // in y with a second roof; the corner is where both meet.
  const auto roof_crossing = [](bool along_x, double shift) {
    Mesh mesh;
    const auto add = [&](float across, float along, float z) {
      mesh.vertices.push_back(along_x ? Eigen::Vector3f(across, along, z)
                                      : Eigen::Vector3f(along, across, z));
    };
    const auto ridge = static_cast<float>(shift);
    for (const float along : {-3.0F, 3.0F}) {
      add(ridge - 2.0F, along, 6.0F);
      add(ridge, along, 4.0F);
      add(ridge + 2.0F, along, 6.0F);
    }
    mesh.faces = {{0, 1, 3}, {1, 4, 3}, {1, 2, 4}, {2, 5, 4}};
    Scene scene(shared_renderer().context());
    scene.add(mesh);
    const Camera camera = pinhole();
    const Rendering view = shared_renderer().render(scene, camera, {.colour = false, .depth = true});
    // On each slope 1 / z is linear in the pixel: a line through two pixels on either side, and their meeting point.
    const double projected =
        (along_x ? camera.fx : camera.fy) * shift / 4.0 + (along_x ? camera.cx : camera.cy);
    const int middle = static_cast<int>(std::lround(projected));
    const auto inverse_depth = [&](int pixel) {
      return 1.0 / view.depth[along_x ? at(camera, pixel, 40) : at(camera, 50, pixel)];
    };
    const double left = inverse_depth(middle - 12);
    const double left_slope = (inverse_depth(middle - 2) - left) / 10.0;
    const double right = inverse_depth(middle + 12);
    const double right_slope = (right - inverse_depth(middle + 2)) / 10.0;
    const double meet = (right - left + left_slope * (middle - 12) - right_slope * (middle + 12)) /
                        (left_slope - right_slope);
    CHECK(meet == Approx(projected).margin(0.05));
  };
  for (const double shift : {-0.31, -0.1, 0.0, 0.017, 0.223}) {
    roof_crossing(true, shift);
    roof_crossing(false, shift);
  }
}

TEST_CASE("an edge's coverage places it within 0.05 pixels") {
  // The mean over the rows of a slightly slanted edge averages the sampling pattern out.
  const Camera camera = pinhole();
  for (const double edge : {-0.2, 0.003, 0.1117}) {
    const auto x_top = static_cast<float>(edge - 0.1);
    const auto x_bottom = static_cast<float>(edge + 0.1);
    Mesh mesh;
    mesh.vertices = {{-5, -0.75F, 2}, {x_top, -0.75F, 2}, {-5, 0.75F, 2}, {x_bottom, 0.75F, 2}};
    mesh.colours.assign(4, {0, 0, 0});
    mesh.faces = {{0, 1, 2}, {2, 1, 3}};
    Scene scene(shared_renderer().context());
    scene.add(mesh);
    const Image image = shared_renderer().render(scene, camera, {.supersample = 2}).image;
    double covered = 0.0;
    for (int v = 10; v < 70; ++v) {
      for (int u = 0; u < camera.width; ++u) covered += (255 - image.at(u, v).r) / 255.0 / 60.0;
    }
    // A pixel spans half a pixel to either side of its centre.
    CHECK(covered - 0.5 == Approx(camera.fx * edge / 2.0 + camera.cx).margin(0.05));
  }
}

TEST_CASE("one-sided meshes are seen from their free side only") {
  const Camera camera = pinhole();
  for (const bool facing : {true, false}) {
    // Counter-clockwise for a viewer at the origin who looks along z with y down.
    Mesh mesh = triangle({-1, 1, 2}, {1, 1, 2}, {0, -1, 2}, kRed, 3);
    if (!facing) std::swap(mesh.faces[0][1], mesh.faces[0][2]);
    Scene scene(shared_renderer().context());
    scene.add(mesh, {.two_sided = false});
    const Rendering view = shared_renderer().render(scene, camera, {.labels = true});
    CHECK(view.image.at(50, 40) == (facing ? kRed : kWhite));
    CHECK(view.labels[at(camera, 50, 40)] == (facing ? 3 : kNoLabel));
  }
}

TEST_CASE("lines have their width in pixels and are cut at the near plane, points are discs and squares") {
  const Camera camera = pinhole();
  {
    Scene scene(shared_renderer().context());
    const std::vector<ColouredPoint> line = {{{-1, 0.0125F, 2}, kRed}, {{1, 0.0125F, 2}, kRed}};
    scene.add_lines(line, {.width_px = 4.0});
    const Image image = shared_renderer().render(scene, camera).image;
    double covered = 0.0;
    for (int v = 0; v < camera.height; ++v) covered += (255 - image.at(50, v).g) / (255.0 - kRed.g);
    CHECK(covered == Approx(4.0).margin(0.3));
    CHECK(image.at(50, 40) == kRed);
  }
  {
    Scene scene(shared_renderer().context());
    const std::vector<ColouredPoint> line = {{{0, 0, 4}, kRed}, {{1, 0, -4}, kRed}};
    const std::vector<ColouredPoint> behind = {{{0, 1, -4}, kRed}, {{1, 0, -4}, kRed}};
    scene.add_lines(line, {.width_px = 3.0});
    scene.add_lines(behind, {.width_px = 3.0});
    const Image image = shared_renderer().render(scene, camera).image;
    CHECK(image.at(80, 40) == kRed);
    CHECK(image.at(20, 40) == kWhite);
    CHECK(image.at(50, 70) == kWhite);
  }
  for (const PointShape shape : {PointShape::kDisc, PointShape::kSquare}) {
    Scene scene(shared_renderer().context());
    const std::vector<ColouredPoint> point = {{{0, 0, 2}, kGreen}};
    scene.add_points(point, {.size_px = 20.0, .shape = shape});
    const Image image = shared_renderer().render(scene, camera).image;
    CHECK(image.at(50, 40) == kGreen);
    CHECK(image.at(58, 48) == (shape == PointShape::kSquare ? kGreen : kWhite));
    CHECK(image.at(62, 40) == kWhite);
  }
}

TEST_CASE("what lies in one plane shows by its layer") {
  const Camera camera = pinhole();
  for (const bool red_on_top : {true, false}) {
    Scene scene(shared_renderer().context());
    const std::vector<ColouredPoint> red = {{{-1, 0, 2}, kRed}, {{1, 0, 2}, kRed}};
    const std::vector<ColouredPoint> green = {{{0, -1, 2}, kGreen}, {{0, 1, 2}, kGreen}};
    scene.add_lines(red, {.width_px = 6.0, .layer = red_on_top ? 1 : 0});
    scene.add_lines(green, {.width_px = 6.0, .layer = red_on_top ? 0 : 1});
    CHECK(shared_renderer().render(scene, camera).image.at(50, 40) == (red_on_top ? kRed : kGreen));
  }
}

TEST_CASE("two renderers live side by side, and a scene outlives its renderer") {
  const Camera camera = pinhole();
  auto other = std::make_unique<Renderer>();
  Scene scene(other->context());
  scene.add(triangle({-9, -9, 4}, {9, -9, 4}, {0, 9, 4}, kRed, 1));
  Scene mine(shared_renderer().context());
  mine.add(triangle({-9, -9, 4}, {9, -9, 4}, {0, 9, 4}, kGreen, 1));
  CHECK(other->render(scene, camera).image.at(50, 20) == kRed);
  CHECK(shared_renderer().render(mine, camera).image.at(50, 20) == kGreen);
  other.reset();
  CHECK(shared_renderer().render(mine, camera).image.at(50, 20) == kGreen);
}

}  // namespace
}  // namespace covey::viewer
