// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/coarse_graph.h"

#include <catch2/catch.hpp>
#include <numbers>
#include <random>

#include "core/pgo/elected_messages.h"
#include "core/pgo/experiment.h"
#include "core/pgo/solve_distributed.h"
#include "core/pgo/start.h"

namespace covey::pgo {
namespace {

constexpr int kLap = 900;  // poses

// A robot drives around a circle of 200 m and on for a third, and knows the places that it sees again.
PoseGraph ring(int seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  PoseGraph graph{2, {kLap + 300}, {}};
  const auto measure = [&](const SE3& T, EdgeKind kind) {
    Vector6d noise;
    noise << 0.02 * normal(random), 0.02 * normal(random), 0.0, 0.0, 0.0, 0.002 * normal(random);
    Edge edge;
    edge.measurement = T * SE3::exp(noise);
    edge.kappa = 0.5 / (0.002 * 0.002);
    edge.tau = 1.0 / (0.02 * 0.02);
    edge.kind = kind;
    edge.known_inlier = kind == EdgeKind::kOdometry;
    return edge;
  };
  const auto add = [&](int from, int to, Edge edge) {
    edge.from.index = from;
    edge.to.index = to;
    graph.edges.push_back(edge);
  };
  const SE3 step{SO3::exp({0.0, 0.0, 2.0 * std::numbers::pi / kLap}), {0.7, 0.0, 0.0}};
  for (int k = 0; k + 1 < graph.poses(); ++k) add(k, k + 1, measure(step, EdgeKind::kOdometry));
  for (int k = 100; k < 300; k += 5) add(k, k + kLap, measure(SE3{}, EdgeKind::kLoop));
  return graph;
}

DistributedOptions in_the_plane() {
  DistributedOptions options;
  options.dgnc.alignment.dimension = 2;
  return options;
}

TEST_CASE("drift around a cycle of robots does not cost right loops") {
  for (const int seed : {1, 2, 3}) {
    const PoseGraph graph = inject_outliers(cut_into_robots(ring(seed), 3), 0.3, seed).graph;
    const DistributedResult team = solve_distributed(graph, in_the_plane());
    CAPTURE(seed);
    // The edges of the cuts, which stand first of all loops.
    CHECK(team.weights[399] == 1.0);
    CHECK(team.weights[799] == 1.0);
  }
}

TEST_CASE("only a team in the plane that starts from odometry is bent") {
  const PoseGraph graph = cut_into_robots(ring(1), 3);
  DistributedOptions options = in_the_plane();
  CHECK(solve_distributed(graph, options).bytes.count("dpgo_graph_t") == 1);
  CHECK(solve_distributed(as_one_robot(graph), options).bytes.count("dpgo_graph_t") == 0);
  CHECK(solve_distributed(graph).bytes.count("dpgo_graph_t") == 0);
  options.start = robust_start(graph, {.min_inliers = 1}).poses;
  CHECK(solve_distributed(graph, options).bytes.count("dpgo_graph_t") == 0);
}

// One segment of 41 keyframes straight ahead, three of them public.
AgreedProblem straight_ahead() {
  AgreedProblem problem;
  problem.part = {0};
  problem.graph.segments = {{7, std::vector<OdometryPose>(41)}};
  problem.starts.resize(1);
  for (int id = 0; id <= 40; ++id) problem.starts[0].T_S_K.push_back({SO3{}, {0.5 * id, 0.0, 0.0}});
  OpenedMember& self = problem.members[0];
  self.join.n_segments = 1;
  self.join.segments = {7};
  for (const int id : {0, 20, 40}) {
    self.places[{0, id}] = static_cast<int>(self.T_S_K.size());
    self.segments.push_back(0);
    self.T_S_K.push_back(problem.starts[0].T_S_K[id]);
  }
  problem.frames.add({0, 0}, 0);
  problem.frames.place({}, 0);
  return problem;
}

TEST_CASE("a segment is bent evenly between its nodes, and ends where they are") {
  AgreedProblem problem = straight_ahead();
  dpgo_poses_t nodes{};
  nodes.dimension = 3;
  nodes.n_segments = 1;
  nodes.robots = nodes.anchors = {0};
  nodes.segments = nodes.anchor_segments = {0};
  nodes.poses = {3};
  const std::vector<SE3> moved = {
      SE3{}, {SO3{}, {10.0, 1.0, 0.0}}, {SO3::exp({0.0, 0.0, 0.2}), {19.8, 3.0, 0.0}}};
  for (const SE3& T : moved) append_floats(T, 3, nodes.values);
  nodes.n_values = static_cast<std::int32_t>(nodes.values.size());
  bend_starts(nodes, {}, problem);
  const std::vector<SE3>& own = problem.starts[0].T_S_K;
  for (int k = 0; k < 3; ++k) {
    CHECK((own[20 * k].inverse() * moved[k]).log().norm() < 1e-6);
    CHECK((problem.self().T_S_K[k].inverse() * moved[k]).log().norm() < 1e-6);
  }
  CHECK(own[10].translation.y() == Approx(0.5).epsilon(0.01));
  for (int id = 1; id <= 40; ++id) {
    const SE3 step = own[id - 1].inverse() * own[id];
    CHECK(step.translation.x() == Approx(0.5).epsilon(0.02));
    CHECK(std::abs(step.translation.y()) < 0.12);
    CHECK(step.rotation.log().norm() < 0.012);
  }

  SECTION("but not by a message that does not fit it") {
    AgreedProblem other = straight_ahead();
    nodes.poses = {2};
    bend_starts(nodes, {}, other);
    CHECK(other.starts[0].T_S_K[40].translation.x() == 20.0);
  }
}

}  // namespace
}  // namespace covey::pgo
