// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/elected.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/solve_distributed.h"
#include "core/pgo/start.h"
#include "core/pgo/team_split.h"
#include "core/sim/grid.h"
#include "tests/core/pgo/worlds.h"

namespace covey::pgo {
namespace {

PoseGraph grid(int robots = 3) {
  return sim::make_grid({.robots = robots, .keyframes = 40, .seed = 4, .min_links = 4}).graph;
}

CentralResult central(const PoseGraph& graph, double barc2) {
  return solve_robust(graph, robust_start(graph, {.min_inliers = 1}).poses, {.barc2 = barc2});
}

DistributedResult solve_elected(const PoseGraph& graph, int dimension = 3, double barc2 = 16.812) {
  DistributedOptions options;
  options.dgnc.solver = RoundSolver::kElected;
  options.dgnc.dimension = dimension;
  options.dgnc.barc2 = barc2;
  return solve_distributed(graph, options);
}

SegmentNames names_of(const std::map<int, TeamMember>& team) {
  SegmentNames names;
  for (const auto& [robot, member] : team) {
    for (const Segment& segment : member.graph.segments) names[robot].push_back(segment.name);
  }
  return names;
}

std::vector<dpgo_graph_t> parts_of(const std::map<int, TeamMember>& team) {
  std::vector<dpgo_graph_t> parts;
  for (const auto& [robot, member] : team) parts.push_back(part_of(member.graph, names_of(team), {}));
  return parts;
}

TEST_CASE("the elected robot finds what the central solver finds") {
  const PoseGraph graph = grid();
  const ElectedOptions options;
  const DistributedResult elected = solve_elected(graph);
  const CentralResult known = central(graph, options.barc2);
  REQUIRE(elected.cost == Approx(known.cost).epsilon(1e-5));
  REQUIRE(robust_cost(graph, elected.poses, options.barc2).cost == Approx(known.cost).epsilon(1e-5));
  for (std::size_t e = 0; e < graph.edges.size(); ++e) REQUIRE(elected.weights[e] == known.weights[e]);
  REQUIRE(std::all_of(elected.placed.begin(), elected.placed.end(), [](bool placed) { return placed; }));
  REQUIRE(elected.poses.front().log().norm() < 1e-6);
}

TEST_CASE("a planar graph is solved as one, with half the numbers") {
  const PoseGraph graph = cut_into_robots(
      make_walk({.dimension = 2, .poses = 200, .rotation_sigma = 0.002, .translation_sigma = 0.01}).graph, 3);
  const PoseGraph spoilt = inject_outliers(graph, 0.3, 1).graph;
  const double barc2 = 20.0;
  const DistributedResult planar = solve_elected(robust_form(spoilt), 2, barc2);
  const CentralResult known = central(spoilt, barc2);
  REQUIRE(planar.cost == Approx(known.cost).epsilon(1e-4));
  for (std::size_t e = 0; e < spoilt.edges.size(); ++e) REQUIRE(planar.weights[e] == known.weights[e]);
  const DistributedResult spatial = solve_elected(robust_form(spoilt), 3, barc2);
  REQUIRE(spatial.cost == Approx(planar.cost).epsilon(1e-4));
  for (const char* type : {"dpgo_graph_t", "dpgo_poses_t"}) {
    REQUIRE(static_cast<double>(planar.bytes.at(type)) < 0.8 * static_cast<double>(spatial.bytes.at(type)));
  }
}

TEST_CASE("every loop is sent once, by its lower robot, and one precision for all that are alike") {
  const PoseGraph graph = grid();
  const auto team = split_team(graph, std::nullopt);
  const std::vector<dpgo_graph_t> parts = parts_of(team);
  int loops = 0;
  for (const dpgo_graph_t& part : parts) {
    REQUIRE(values_are_good(part));
    loops += part.n_loops;
    for (const int b : part.robots_b) REQUIRE(b >= part.from);
    REQUIRE(part.n_precisions == 2 * (39 + part.n_loops));  // odometry is not as good as closures are
  }
  REQUIRE(loops == graph.loops());

  PoseGraph alike = graph;
  for (Edge& edge : alike.edges) edge.kappa = edge.tau = 100.0;
  for (const dpgo_graph_t& part : parts_of(split_team(alike, std::nullopt))) {
    REQUIRE(part.precisions == std::vector<float>{100.0F, 100.0F});
    REQUIRE(values_are_good(part));
  }
  // Six floats for each measurement or pose and 8 bytes for a loop's ends, and little else.
  const DistributedResult result = solve_elected(alike);
  const int sent_loops = parts[1].n_loops + parts[2].n_loops;
  const auto& bytes = result.bytes;
  REQUIRE(bytes.at("dpgo_graph_t") < 24 * (2 * 39 + sent_loops) + 8 * sent_loops + 400);
  REQUIRE(bytes.at("dpgo_poses_t") < 24 * 2 * 40 + graph.loops() / 8 + 4 * parts[0].n_loops + 400);
}

TEST_CASE("every robot learns its poses and what became of its loops, whichever way they were measured") {
  const PoseGraph graph = grid();
  const auto team = split_team(graph, std::nullopt);
  const SegmentNames names = names_of(team);
  const Gathered gathered = solve_parts(parts_of(team), {});
  const dpgo_poses_t sent = without_own(gathered.poses);
  REQUIRE(values_are_good(sent));
  REQUIRE(sent.n_values == 6 * 2 * 40);
  const DistributedResult whole = solve_elected(graph);
  const std::vector<double> r2 = squared_residuals(graph, whole.poses);
  std::vector<int> told(graph.edges.size(), 0);
  int backward = 0;
  for (const auto& [robot, member] : team) {
    const auto share = share_of(robot == 0 ? gathered.poses : sent, member.graph, names, {});
    REQUIRE(share);
    REQUIRE(static_cast<int>(share->loops.size()) == member.graph.loops());
    for (const ElectedShare::Decision& decision : share->loops) {
      const std::uint64_t edge = decision.loop.key;
      ++told[edge];
      backward += graph.edges[edge].from.robot > graph.edges[edge].to.robot ? 1 : 0;
      REQUIRE(decision.kept == (whole.weights[edge] == 1.0));
      REQUIRE(decision.r2 == Approx(r2[edge]).epsilon(1e-3).margin(1e-3));
    }
  }
  REQUIRE(backward > 0);
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const Edge& edge = graph.edges[e];
    REQUIRE(told[e] == (edge.kind == EdgeKind::kOdometry ? 0 : edge.between_robots() ? 2 : 1));
  }
}

TEST_CASE("segments are placed like robots, and what nothing connects is told so") {
  PoseGraph graph = grid(4);
  const auto gone = [&](const Edge& edge) {
    const bool link_of_3 = edge.between_robots() && (edge.from.robot == 3 || edge.to.robot == 3);
    const bool break_in_1 = edge.kind == EdgeKind::kOdometry && edge.from == PoseId{1, 20};
    return link_of_3 || break_in_1;
  };
  graph.edges.erase(std::remove_if(graph.edges.begin(), graph.edges.end(), gone), graph.edges.end());
  const auto team = split_team(graph, std::nullopt);
  REQUIRE(team.at(1).graph.segments.size() == 2);
  const DistributedResult result = solve_elected(graph);
  REQUIRE(result.placed[0]);
  REQUIRE(result.placed[45]);
  REQUIRE(result.placed[70]);
  REQUIRE_FALSE(result.placed[120]);
  const dpgo_poses_t sent = without_own(solve_parts(parts_of(team), {}).poses);
  const auto apart = share_of(sent, team.at(3).graph, names_of(team), {});
  REQUIRE(apart);
  REQUIRE(apart->segments[0].anchor == 3);
  REQUIRE(apart->segments[0].T_F_K.size() == 40);
  REQUIRE(apart->segments[0].T_F_K[0].log().norm() < 1e-6);
}

TEST_CASE("a loop that is known to be right is never rejected") {
  PoseGraph graph = grid();
  Edge wrong = graph.edges.front();
  wrong.measurement.translation.x() += 100.0;  // a doubled odometry edge
  graph.edges.push_back(wrong);
  wrong.kind = EdgeKind::kLoop;
  wrong.known_inlier = false;
  graph.edges.push_back(wrong);
  const DistributedResult result = solve_elected(graph);
  REQUIRE(result.weights[graph.edges.size() - 2] == 1.0);
  REQUIRE(result.weights.back() == 0.0);
}

TEST_CASE("rotations of half a turn and far-away poses survive the packing") {
  std::vector<float> values;
  const std::vector<SE3> poses = {{},
                                  {SO3::exp({3.1415, 0.0, 0.0}), {1.0, 2.0, 3.0}},
                                  {SO3::exp({0.1, -2.0, 2.4}), {-800.0, 500.0, 10.0}}};
  for (const SE3& T : poses) append_floats(T, 3, values);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Vector6d error = (poses[k].inverse() * pose_from_floats(values, static_cast<int>(k), 3)).log();
    REQUIRE(error.head<3>().norm() < 1e-4);
    REQUIRE(error.tail<3>().norm() < 1e-6);
  }
  REQUIRE(bit_at(pack_bits({false, true, true, false, false, false, false, true, false, true}), 7));
  REQUIRE_FALSE(bit_at(pack_bits({false, true, true, false, false, false, false, true, false, true}), 8));
  REQUIRE(bit_at(pack_bits({false, true, true, false, false, false, false, true, false, true}), 9));
}

TEST_CASE("what cannot be what it says it is has no good values") {
  const auto team = split_team(grid(), std::nullopt);
  const dpgo_graph_t good = parts_of(team)[1];
  const auto spoilt = [&](auto change) {
    dpgo_graph_t message = good;
    change(message);
    return values_are_good(message);
  };
  REQUIRE(spoilt([](dpgo_graph_t&) {}));
  REQUIRE_FALSE(spoilt([](dpgo_graph_t& m) { m.values[7] = std::numeric_limits<float>::quiet_NaN(); }));
  REQUIRE_FALSE(spoilt([](dpgo_graph_t& m) { m.precisions[3] = 0.0F; }));
  REQUIRE_FALSE(spoilt([](dpgo_graph_t& m) { m.poses[0] += 1; }));
  REQUIRE_FALSE(spoilt([](dpgo_graph_t& m) { m.sizes[0] -= 1; }));
  REQUIRE_FALSE(spoilt([](dpgo_graph_t& m) { m.segments_a[0] = 1; }));
  REQUIRE_FALSE(spoilt([](dpgo_graph_t& m) { m.ids_b[0] = -1; }));
  REQUIRE_FALSE(spoilt([](dpgo_graph_t& m) { m.dimension = 4; }));

  // An end that is not there costs the loop, not the round.
  std::vector<dpgo_graph_t> parts = parts_of(team);
  parts[0].ids_b.back() = 1000;
  const dpgo_poses_t poses = solve_parts(parts, {}).poses;
  REQUIRE(values_are_good(poses));
  dpgo_poses_t short_of_one = poses;
  short_of_one.loops.back() -= 1;
  REQUIRE_FALSE(share_of(short_of_one, team.at(2).graph, names_of(team), {}));
  dpgo_poses_t nowhere = poses;
  nowhere.anchors.back() = 77;
  REQUIRE_FALSE(share_of(nowhere, team.at(2).graph, names_of(team), {}));
  short_of_one = poses;
  short_of_one.values.pop_back();
  short_of_one.n_values -= 1;
  REQUIRE_FALSE(values_are_good(short_of_one));
}

}  // namespace
}  // namespace covey::pgo
