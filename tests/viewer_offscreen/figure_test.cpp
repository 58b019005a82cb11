// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/figure.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "shared_renderer.h"
#include "viewer_offscreen/ground.h"
#include "viewer_offscreen/png.h"
#include "viewer_offscreen/text.h"

namespace covey::viewer {
namespace {

constexpr FigureOptions kSmall = {.size = {400, 320}};

FigureContent team(int robots, double extent, const Eigen::Vector3d& centre = Eigen::Vector3d::Zero()) {
  FigureContent content;
  content.title = "team";
  for (int robot = 0; robot < robots; ++robot) {
    Curve curve;
    curve.name = "robot" + std::to_string(robot);
    for (int i = 0; i <= 60; ++i) {
      const double angle = 0.1 * i + robot;
      curve.points_W.push_back(centre + 0.4 * extent *
                                            Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.02 * robot));
    }
    content.trajectories.push_back(curve);
  }
  return content;
}

int count(const Image& image, Rgb colour, int first_column) {
  int pixels = 0;
  for (int row = 0; row < image.height; ++row) {
    for (int column = first_column; column < image.width; ++column)
      pixels += image.at(column, row) == colour ? 1 : 0;
  }
  return pixels;
}

TEST_CASE("every robot's colour is in the plot and in the legend, in both views") {
  FigureContent content = team(4, 20.0);
  content.trajectories[1].colour = Rgb{1, 2, 250};
  for (const View view : {View::kTop, View::kOblique}) {
    const Image image = draw_figure(shared_renderer(), content, view, {.size = {640, 480}});
    CHECK(image.width == 640);
    CHECK(image.height == 480);
    for (int robot = 0; robot < 4; ++robot) {
      const Rgb colour = robot == 1 ? Rgb{1, 2, 250} : palette_colour(robot);
      const int in_legend = count(image, colour, 545);
      CHECK(in_legend > 5);
      CHECK(count(image, colour, 0) > in_legend + 5);
    }
  }
}

TEST_CASE("references of one name share one entry of the legend") {
  const auto drawn_with = [](const std::vector<std::string>& more_names) {
    FigureContent content = team(1, 20.0);
    content.references.push_back({"truth", content.trajectories[0].points_W, std::nullopt});
    for (const std::string& name : more_names) content.references.push_back({name, {}, std::nullopt});
    return encode_png(draw_figure(shared_renderer(), content, View::kTop, kSmall));
  };
  CHECK(drawn_with({}) == drawn_with({"truth", "truth"}));
  CHECK(drawn_with({}) != drawn_with({"other"}));
}

TEST_CASE("equal content gives equal bytes") {
  const FigureContent content = team(2, 10.0);
  const std::vector<std::uint8_t> first =
      encode_png(draw_figure(shared_renderer(), content, View::kOblique, kSmall));
  CHECK(first == encode_png(draw_figure(shared_renderer(), content, View::kOblique, kSmall)));
  Renderer fresh;
  CHECK(first == encode_png(draw_figure(fresh, content, View::kOblique, kSmall)));
}

TEST_CASE("a figure looks the same at every scale and far from the origin") {
  const Image metre = draw_figure(shared_renderer(), team(2, 1.0), View::kTop, kSmall);
  for (const double extent : {1.0, 10000.0}) {
    const Eigen::Vector3d utm(691000.0 * (extent > 1.0 ? 1.0 : 0.0), 5335000.0, 520.0);
    const Image image = draw_figure(shared_renderer(), team(2, extent, utm), View::kTop, kSmall);
    for (int robot = 0; robot < 2; ++robot) {
      const int expected = count(metre, palette_colour(robot), 0);
      CHECK(std::abs(count(image, palette_colour(robot), 0) - expected) < expected / 5);
    }
  }
}

TEST_CASE("a figure of one pose, of loops alone, and of a mesh alone is drawn") {
  FigureContent one;
  one.trajectories.push_back({"a", {{5.0, 5.0, 5.0}}, std::nullopt});
  FigureContent loops;
  loops.loops.push_back({{0, 0, 0}, {1, 1, 0}, LoopStatus::kFalse});
  FigureContent mesh;
  mesh.meshes.push_back({{{0, 0, 0}, {4, 0, 0}, {0, 4, 1}}, {}, {3, 3, 3}, {{0, 1, 2}}});
  for (const View view : {View::kTop, View::kOblique}) {
    CHECK(count(draw_figure(shared_renderer(), one, view, kSmall), palette_colour(0), 0) > 10);
    CHECK(count(draw_figure(shared_renderer(), loops, view, kSmall), {255, 255, 255}, 0) > 1000);
    CHECK(count(draw_figure(shared_renderer(), mesh, view, kSmall), label_colour(3), 0) > 20);
  }
  CHECK_FALSE(has_content({}));
}

TEST_CASE("meshes have colours of their own under trajectories by robot, and classes their names") {
  FigureContent content;
  content.trajectories.push_back({"a", {{0.0, 0.0, 1.0}, {4.0, 4.0, 1.0}}, std::nullopt});
  content.meshes.push_back(
      {{{0, 0, 0}, {6, 0, 0}, {6, 6, 0}, {0, 6, 0}}, {}, {3, 3, 3, 255}, {{0, 1, 2}, {0, 2, 3}}});
  content.classes[3] = {"kiosk", {1, 2, 250}};
  content.mesh_colour = ColourBy::kLabel;
  const Image by_label = draw_figure(shared_renderer(), content, View::kTop, kSmall);
  CHECK(count(by_label, palette_colour(0), 0) > 20);
  const int in_legend = count(by_label, {1, 2, 250}, kSmall.size.width - 60);
  CHECK(in_legend > 5);
  CHECK(count(by_label, label_colour(3), 0) == 0);
  content.mesh_colour = ColourBy::kHeight;
  const Image by_height = draw_figure(shared_renderer(), content, View::kTop, kSmall);
  CHECK(count(by_height, palette_colour(0), 0) > 20);
  CHECK(count(by_height, {1, 2, 250}, 0) == 0);
  // A stray far above leaves the rest its colours: what is high is still yellow.
  content.trajectories.clear();
  content.meshes[0] = {};
  for (std::uint32_t k = 0; k < 400; ++k) {
    const float x = 0.01F * static_cast<float>(k);
    for (const float y : {0.0F, 4.0F}) content.meshes[0].vertices.emplace_back(x, y, x);
    if (k > 0)
      content.meshes[0].faces.insert(content.meshes[0].faces.end(),
                                     {{2 * k - 2, 2 * k, 2 * k + 1}, {2 * k - 2, 2 * k + 1, 2 * k - 1}});
  }
  const auto yellow = [&] {
    const Image image = draw_figure(shared_renderer(), content, View::kTop, kSmall);
    int pixels = 0;
    for (int row = 0; row < image.height; ++row) {
      for (int column = 0; column < 300; ++column) {
        const Rgb at = image.at(column, row);
        pixels += at.r > 120 && at.g > 150 && at.b < 110 ? 1 : 0;
      }
    }
    return pixels;
  };
  const int before = yellow();
  CHECK(before > 500);
  content.meshes[0].vertices[400].z() = 500.0F;
  CHECK(yellow() > 20);  // of a smaller picture of it
}

TEST_CASE("lengths are round") {
  CHECK(round_length(0.9) == Approx(1.0));
  CHECK(round_length(1.0) == Approx(1.0));
  CHECK(round_length(1.2) == Approx(2.0));
  CHECK(round_length(0.021) == Approx(0.05));
  CHECK(round_length(510.0) == Approx(1000.0));
  CHECK(format_length(0.05) == "5 cm");
  CHECK(format_length(20.0) == "20 m");
  CHECK(format_length(2000.0) == "2 km");
}

TEST_CASE("ticks are short, and zero has no sign") {
  CHECK(tick_text(-0.0) == "0");
  CHECK(tick_text(0.0) == "0");
  CHECK(tick_text(-20.0) == "-20");
  CHECK(tick_text(0.5) == "0.5");
}

TEST_CASE("the ground lies under the content with a margin and has the wanted shape") {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-10, 0, -1), Eigen::Vector3d(30, 10, 4));
  const Ground ground = plan_ground(box, 1.5);
  CHECK(ground.x_low < -10.0);
  CHECK(ground.x_high > 30.0);
  CHECK(ground.y_low < 0.0);
  CHECK(ground.y_high > 10.0);
  CHECK(ground.z == -1.0);
  CHECK((ground.x_high - ground.x_low) / (ground.y_high - ground.y_low) == Approx(1.5));
  CHECK(ground.step == Approx(5.0));
}

TEST_CASE("every printable letter has a width and can be drawn, text grows with its height") {
  Scene scene(shared_renderer().context());
  std::string all;
  for (char letter = ' '; letter <= '~'; ++letter) {
    all += letter;
    CHECK(text_width(std::string(1, letter), 14.0) > 0.0);
  }
  add_text(scene, all, 0.0, 100.0);
  add_text(scene, "\xc3\xa4", 0.0, 100.0);
  CHECK(text_width(all, 28.0) == Approx(2.0 * text_width(all, 14.0)));
  CHECK(text_width("", 14.0) == 0.0);
}

}  // namespace
}  // namespace covey::viewer
