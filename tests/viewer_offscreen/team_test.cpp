// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/team.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "tests/viewer_offscreen/team_messages.h"
#include "viewer_offscreen/colour.h"

namespace covey::viewer {
namespace {

FigureContent content_of(const Team& team) {
  FigureContent content;
  team.add_to(content);
  return content;
}

std::string said(const char* reason) { return reason == nullptr ? "" : reason; }

TEST_CASE("the newest whole round wins, in whatever order its parts come") {
  Team team;
  CHECK(said(team.take(trajectory_part(2, 10, {{0, 0, 0}, {1, 0, 0}}))).empty());
  CHECK(said(team.take(trajectory_part(2, 20, {{6, 0, 0}}, 1, 2, 1))).empty());
  CHECK(content_of(team).trajectories.at(0).points_W.back().x() == 1.0);  // the newer one is not whole
  CHECK(team.rounds() == 1);
  CHECK(said(team.take(trajectory_part(2, 20, {{6, 0, 0}}, 1, 2, 1))) == "duplicate");
  CHECK(said(team.take(trajectory_part(2, 15, {{9, 0, 0}}))) == "old");
  CHECK(said(team.take(trajectory_part(2, 20, {{9, 0, 0}}, 2, 3))) == "values");
  CHECK(said(team.take(trajectory_part(2, 20, {{5, 0, 0}}, 0, 2, 0))).empty());
  CHECK(said(team.take(trajectory_part(2, 20, {{5, 0, 0}}, 0, 2, 0))) == "duplicate");
  CHECK(team.rounds() == 2);
  const FigureContent content = content_of(team);
  REQUIRE(content.trajectories.size() == 1);
  const Curve& curve = content.trajectories[0];
  CHECK(curve.name == "robot2");
  CHECK(curve.colour == palette_colour(2));
  REQUIRE(curve.points_W.size() == 2);
  CHECK(curve.points_W[0].x() == 5.0);
  CHECK(curve.points_W[1].x() == 6.0);
}

TEST_CASE("a loop is said by its lower robot, and drawn where both ends are known") {
  Team team;
  team.take(trajectory_part(0, 10, {{0, 0, 0}, {1, 0, 0}}));
  team.take(trajectory_part(1, 10, {{0, 5, 0}, {1, 5, 0}}));
  team.take(weights_part(1, 10, {{0, 1, 1, 0, 0.2}, {1, 0, 1, 1, 0.1}, {1, 0, 2, 0, 1.0}}));
  CHECK(content_of(team).loops.size() == 2);  // robot 0 has said nothing of its loops yet
  team.take(weights_part(0, 10, {{0, 1, 1, 0, 0.9}, {0, 0, 1, 77, 1.0}}));
  const FigureContent content = content_of(team);
  REQUIRE(content.loops.size() == 2);
  CHECK(content.loops[0].status == LoopStatus::kAccepted);
  CHECK(content.loops[0].from_W == Eigen::Vector3d(1, 0, 0));
  CHECK(content.loops[0].to_W == Eigen::Vector3d(0, 5, 0));
  CHECK(content.loops[1].status == LoopStatus::kRejected);
}

TEST_CASE("who is in another robot's W is named so, and no loop joins the two") {
  Team team;
  trajectory_t apart = trajectory_part(1, 10, {{0, 5, 0}});
  apart.anchor = 1;
  team.take(trajectory_part(0, 10, {{0, 0, 0}}));
  team.take(apart);
  team.take(weights_part(0, 10, {{0, 0, 1, 0, 1.0}}));
  const FigureContent content = content_of(team);
  CHECK(content.trajectories.at(1).name == "robot1 (W of robot1)");
  CHECK(content.loops.empty());
}

TEST_CASE("values that nothing can be drawn of are refused") {
  Team team;
  for (const double x : {std::nan(""), HUGE_VAL, -1e300})
    CHECK(said(team.take(trajectory_part(0, 10, {{1, 1, 1}, {x, 0, 0}}))) == "values");
  for (const int robot : {-1, 20})
    CHECK(said(team.take(trajectory_part(robot, 10, {{0, 0, 0}}))) == "values");
  CHECK(said(team.take(trajectory_part(0, 10, {{0, 0, 0}}, 1, 1))) == "values");
  CHECK(said(team.take(trajectory_part(0, 10, {{0, 0, 0}}, -1, 1))) == "values");
  CHECK(said(team.take(trajectory_part(0, 10, {{0, 0, 0}}, 0, 0))) == "values");
  CHECK(said(team.take(trajectory_part(0, 10, {{0, 0, 0}}, 0, 2'000'000'000))) == "values");
  trajectory_t half = trajectory_part(0, 10, {{0, 0, 0}});
  half.T_W_K.pop_back();
  --half.n_values;
  CHECK(said(team.take(half)) == "values");
  CHECK(team.rounds() == 0);
  CHECK(said(team.take(trajectory_part(0, 10, {}))).empty());
  CHECK(team.robots() == 0);
  CHECK(content_of(team).trajectories.empty());
}

TEST_CASE("whatever is taken can be drawn") {
  Renderer renderer;
  for (const double size : {0.0, 1e-300, 9e7}) {
    Team team;
    team.take(trajectory_part(0, 10, {{-size, size, -size}, {size, -size, size}}));
    team.take(weights_part(0, 10, {{0, 0, 0, 1, std::nan("")}}));
    for (const View view : {View::kTop, View::kOblique})
      CHECK(draw_figure(renderer, content_of(team), view, {.size = {320, 320}}).width == 320);
  }
}

}  // namespace
}  // namespace covey::viewer
