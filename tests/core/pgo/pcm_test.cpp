// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pcm.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "core/pgo/chi_square.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "worlds.h"

using namespace covey;
using namespace covey::pgo;

namespace {

// Noise-free edges of a walk; `noisy` draws all of them anew.
struct NoisyTeam {
  PoseGraph graph;

  PoseGraph noisy(std::mt19937_64& random) const {
    std::normal_distribution<double> normal;
    PoseGraph drawn = graph;
    for (Edge& edge : drawn.edges) {
      const double rotation =
          graph.dimension == 2 ? 1.0 / std::sqrt(edge.kappa) : std::sqrt(0.5 / edge.kappa);
      Vector6d noise;
      for (int axis = 0; axis < 6; ++axis)
        noise[axis] = (axis < 3 ? 1.0 / std::sqrt(edge.tau) : rotation) * normal(random);
      if (graph.dimension == 2) noise.segment<3>(2).setZero();
      edge.measurement = edge.measurement * SE3::exp(noise);
    }
    return drawn;
  }
};

// Robots of one walk, with the loops that the last edges name, true to the last digit.
NoisyTeam make_team(int dimension, int robots, const std::vector<std::pair<int, int>>& loops) {
  const Walk walk =
      make_walk({.dimension = dimension, .poses = 80, .rotation_sigma = 0.004, .translation_sigma = 0.01});
  PoseGraph graph{dimension, {80}, {}};
  for (const Edge& edge : walk.graph.edges) {
    if (edge.kind == EdgeKind::kOdometry) graph.edges.push_back(edge);
  }
  for (const auto& [i, j] : loops) {
    Edge edge = walk.graph.edges.front();
    edge.from.index = i;
    edge.to.index = j;
    edge.kind = EdgeKind::kLoop;
    edge.known_inlier = false;
    graph.edges.push_back(edge);
  }
  for (Edge& edge : graph.edges)
    edge.measurement = walk.truth[edge.from.index].inverse() * walk.truth[edge.to.index];
  return {cut_into_robots(graph, robots)};
}

// The error of a cycle over many draws of all noises, whitened by the covariance that is claimed for it, has covariance I.
void check_covariance(const NoisyTeam& team, bool single) {
  const int last = static_cast<int>(team.graph.edges.size()) - 1;
  const auto cycle_of = [&](const PoseGraph& graph) {
    PairwiseConsistency consistency;
    consistency.update(graph);
    return single ? consistency.cycle_of(last) : consistency.cycle_of(last - 1, last);
  };
  const CycleError exact = cycle_of(team.graph);
  CHECK(exact.xi.norm() < 1e-9);
  const std::vector<int> axes =
      team.graph.dimension == 2 ? std::vector<int>{0, 1, 5} : std::vector<int>{0, 1, 2, 3, 4, 5};
  const Eigen::MatrixXd claimed = exact.covariance(axes, axes);
  constexpr int kDraws = 2000;
  std::mt19937_64 random(7);
  Eigen::MatrixXd sampled = Eigen::MatrixXd::Zero(claimed.rows(), claimed.cols());
  double squared = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const CycleError error = cycle_of(team.noisy(random));
    const Eigen::VectorXd xi = error.xi(axes);
    sampled += xi * xi.transpose() / kDraws;
    squared += error.squared_mahalanobis() / kDraws;
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> whitened(sampled, claimed);
  CHECK(whitened.eigenvalues().minCoeff() > 0.8);
  CHECK(whitened.eigenvalues().maxCoeff() < 1.2);
  CHECK(squared == Approx(static_cast<double>(axes.size())).epsilon(0.05));
}

struct Planted {
  PoseGraph graph;
  std::vector<bool> is_true;
};

Planted plant(int dimension, int robots) {
  const Walk walk =
      make_walk({.dimension = dimension, .poses = 300, .rotation_sigma = 0.003, .translation_sigma = 0.02});
  const Injection injection = inject_outliers(cut_into_robots(walk.graph, robots), 0.4, 3);
  return {injection.graph, injection.is_true};
}

double quantile(int dimension, double probability) {
  return chi_square_quantile(probability, pose_degrees_of_freedom(dimension));
}

}  // namespace

TEST_CASE("the covariance of two loops' cycle is that of many draws, wherever the loops lie") {
  for (const int dimension : {2, 3}) {
    INFO("dimension " << dimension);
    check_covariance(make_team(dimension, 2, {{10, 70}, {33, 52}}), false);
    check_covariance(make_team(dimension, 2, {{70, 10}, {33, 52}}),
                     false);  // one that was measured the other way
    check_covariance(make_team(dimension, 1, {{5, 60}, {20, 75}}), false);  // stretches apart
    check_covariance(make_team(dimension, 1, {{5, 40}, {30, 75}}),
                     false);  // stretches that overlap, in one sense
    check_covariance(make_team(dimension, 1, {{5, 75}, {45, 20}}),
                     false);  // and in the other, measured backwards
    check_covariance(make_team(dimension, 1, {{12, 66}}), true);
  }
}

TEST_CASE("of planted outliers none is kept, and nearly all true loops are") {
  for (const int robots : {1, 3}) {
    for (const int dimension : {2, 3}) {
      INFO(robots << " robots, dimension " << dimension);
      const Planted planted = plant(dimension, robots);
      const PcmResult result = consistent_loops(planted.graph, {.barc2 = quantile(dimension, 0.9999)});
      CHECK(result.exact);
      const LoopScore score = score_loops(planted.graph, result.kept, planted.is_true);
      CHECK(score.precision > 0.97);  // a wrong loop may fit by chance where odometry is loose
      CHECK(score.recall > 0.9);
      std::set<std::pair<int, int>> pairs;
      int loops = 0;
      for (const PcmGroup& group : result.groups) {
        CHECK(group.a <= group.b);
        CHECK(pairs.insert({group.a, group.b}).second);
        CHECK(group.kept <= group.loops);
        CHECK(group.agreeing_pairs >= group.kept * (group.kept - 1) / 2);
        loops += group.loops;
      }
      CHECK(loops == planted.graph.loops());
      CHECK(keep_edges(planted.graph, result.kept).loops() ==
            std::count(result.kept.begin(), result.kept.end(), true) -
                (static_cast<int>(planted.graph.edges.size()) - planted.graph.loops()));
    }
  }
}

TEST_CASE("a lone loop between two robots is kept, a robot's own one only if it fits the odometry") {
  NoisyTeam two = make_team(3, 2, {{10, 70}});
  two.graph.edges.erase(std::find_if(two.graph.edges.begin(), two.graph.edges.end(),
                                     [](const Edge& edge) { return edge.between_robots(); }));  // the cut
  two.graph.edges.back().measurement.translation.x() += 50.0;
  CHECK(consistent_loops(two.graph).kept.back());
  NoisyTeam one = make_team(3, 1, {{10, 70}, {20, 60}});
  one.graph.edges.back().measurement.translation.x() += 50.0;
  const PcmResult result = consistent_loops(one.graph);
  CHECK(!result.kept.back());
  CHECK(result.kept[result.kept.size() - 2]);
  REQUIRE(result.groups.size() == 1);
  CHECK(result.groups.front().kept == 1);
}

TEST_CASE("robots with broken odometry are judged piece by piece, and stay connected") {
  Planted planted = plant(3, 2);
  std::size_t first_step = 0;
  while (planted.graph.edges[first_step].to != PoseId{0, 100}) ++first_step;
  planted.graph.edges.erase(planted.graph.edges.begin() + static_cast<std::ptrdiff_t>(first_step));
  const PcmResult result = consistent_loops(planted.graph);
  CHECK(result.groups.size() == 6);  // three chains
  const std::vector<int> parts = connected_parts(keep_edges(planted.graph, result.kept));
  CHECK(*std::max_element(parts.begin(), parts.end()) == 0);
}

TEST_CASE("a graph that grows is decided as one that is there at once") {
  const Planted planted = plant(3, 3);
  const PcmOptions options{.barc2 = quantile(3, 0.99)};
  const PcmResult batch = consistent_loops(planted.graph, options);
  PairwiseConsistency consistency(options);
  PoseGraph grown{3, {}, {}};
  // Odometry first, then loops in ten instalments.
  std::vector<Edge> loops;
  std::vector<std::size_t> order;
  for (const EdgeKind kind : {EdgeKind::kOdometry, EdgeKind::kLoop}) {
    for (std::size_t e = 0; e < planted.graph.edges.size(); ++e) {
      if (planted.graph.edges[e].kind == kind) order.push_back(e);
    }
  }
  grown.poses_per_robot = planted.graph.poses_per_robot;
  const std::size_t instalment = 1 + order.size() / 10;
  PcmResult incremental;
  for (std::size_t k = 0; k < order.size(); ++k) {
    grown.edges.push_back(planted.graph.edges[order[k]]);
    const bool odometry_is_there = grown.edges.back().kind == EdgeKind::kLoop || k + 1 == order.size();
    if (!odometry_is_there || ((k + 1) % instalment != 0 && k + 1 != order.size())) continue;
    consistency.update(grown);
    incremental = consistency.solve();
    CHECK(incremental.kept.size() == grown.edges.size());
  }
  for (std::size_t k = 0; k < order.size(); ++k) REQUIRE(incremental.kept[k] == batch.kept[order[k]]);
  // New poses carry on with their robot's odometry.
  const NoisyTeam team = make_team(3, 1, {{10, 30}, {15, 70}});
  PairwiseConsistency later;
  PoseGraph part{3, {40}, {}};
  for (const Edge& edge : team.graph.edges) {
    if (edge.from.index < 40 && edge.to.index < 40) part.edges.push_back(edge);
  }
  later.update(part);
  part.poses_per_robot = {80};
  for (const Edge& edge : team.graph.edges) {
    if (edge.from.index >= 40 || edge.to.index >= 40) part.edges.push_back(edge);
  }
  later.update(part);
  PairwiseConsistency once;
  once.update(team.graph);
  const int last = static_cast<int>(team.graph.edges.size()) - 1;
  const CycleError now = once.cycle_of(last - 1, last);
  const CycleError then = later.cycle_of(39, last);
  CHECK((now.covariance - then.covariance).norm() < 1e-12);
}

TEST_CASE("what pairs would tell each other is counted per loop between robots") {
  const NoisyTeam team = make_team(3, 2, {{10, 70}, {10, 20}});
  const PcmResult result = consistent_loops(team.graph);
  CHECK(exchange_bytes(result) == 2 * (28 * 8 + 1));  // the cut itself is a loop between robots, too
}
