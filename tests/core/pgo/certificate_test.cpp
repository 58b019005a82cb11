// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/certificate.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <numbers>
#include <random>
#include <string>

#include "core/pgo/central.h"
#include "core/pgo/cost.h"
#include "core/pgo/experiment.h"
#include "core/pgo/g2o.h"
#include "core/pgo/start.h"
#include "tests/data.h"
#include "worlds.h"

using namespace covey;
using namespace covey::pgo;

namespace {

// A ring of robots' poses, each 1 m and 1/n of a turn from the one before, with some noise. The start has `windings` turns
// more than the measurements; one more cannot be undone by small steps.
struct Ring {
  PoseGraph graph;
  Poses wound;
};

Ring make_ring(int dimension, int poses, int windings) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  Ring ring;
  ring.graph = {dimension, {poses}, {}};
  const double turn = 2.0 * std::numbers::pi / poses;
  for (int k = 0; k < poses; ++k) {
    Vector6d noise = Vector6d::Zero();
    for (int axis = 0; axis < 6; ++axis) noise[axis] = 0.005 * normal(random);
    if (dimension == 2) noise.segment<3>(2).setZero();
    const SE3 step = SE3{SO3::exp({0, 0, turn}), {1, 0, 0}} * SE3::exp(noise);
    const bool last = k + 1 == poses;
    ring.graph.edges.push_back({{0, k},
                                {0, (k + 1) % poses},
                                step,
                                100.0,
                                1.0,
                                last ? EdgeKind::kLoop : EdgeKind::kOdometry,
                                !last});
    ring.wound.push_back({SO3::exp({0, 0, (1 + windings) * turn * k}), Eigen::Vector3d::Zero()});
  }
  return ring;
}

// eta by its definition: the translations eliminated from the dense S by a pseudo-inverse, the lowest eigenvalue of the rest.
double dense_eta(const PoseGraph& graph, const Poses& poses) {
  const int d = graph.dimension;
  const int n = graph.poses();
  const std::vector<int> offsets = graph.offsets();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Zero((d + 1) * n, (d + 1) * n);
  Eigen::MatrixXd X(d, (d + 1) * n);
  for (int k = 0; k < n; ++k) {
    X.middleCols(k * (d + 1), d) = rotation_of(poses[k], d);
    X.col(k * (d + 1) + d) = translation_of(poses[k], d);
  }
  for (const Edge& edge : graph.edges) {
    Eigen::MatrixXd difference = Eigen::MatrixXd::Zero((d + 1) * n, d + 1);  // X_to - X_from M = X * this
    Eigen::MatrixXd M = Eigen::MatrixXd::Identity(d + 1, d + 1);
    M.topLeftCorner(d, d) = rotation_of(edge.measurement, d);
    M.topRightCorner(d, 1) = translation_of(edge.measurement, d);
    difference.middleRows((d + 1) * (offsets[edge.to.robot] + edge.to.index), d + 1).setIdentity();
    difference.middleRows((d + 1) * (offsets[edge.from.robot] + edge.from.index), d + 1) -= M;
    Eigen::VectorXd omega = Eigen::VectorXd::Constant(d + 1, edge.kappa);
    omega[d] = edge.tau;
    Q += difference * omega.asDiagonal() * difference.transpose();
  }
  CHECK((X * Q * X.transpose()).trace() == Approx(cost(graph, poses)));
  std::vector<int> rotations;
  std::vector<int> translations;
  for (int k = 0; k < n; ++k) {
    for (int c = 0; c < d; ++c) rotations.push_back(k * (d + 1) + c);
    translations.push_back(k * (d + 1) + d);
  }
  const Eigen::MatrixXd Q_rt = Q(rotations, translations);
  const Eigen::MatrixXd Q_tt = Q(translations, translations);
  const Eigen::MatrixXd reduced =
      Q(rotations, rotations) -
      Q_rt * Q_tt.completeOrthogonalDecomposition().pseudoInverse() * Q_rt.transpose();
  const Eigen::MatrixXd R = X(Eigen::all, rotations);
  Eigen::MatrixXd S = reduced;
  for (int k = 0; k < n; ++k) {
    const Eigen::MatrixXd gradient = R.middleCols(d * k, d).transpose() * (R * reduced).middleCols(d * k, d);
    S.block(d * k, d * k, d, d) -= 0.5 * (gradient + gradient.transpose());
  }
  return std::max(0.0, -Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S).eigenvalues().minCoeff());
}

}  // namespace

TEST_CASE("eta is the dense matrix's, away from any optimum, for a robot and for teams") {
  for (const int dimension : {2, 3}) {
    const Walk walk = make_walk({.dimension = dimension, .poses = 40, .rotation_sigma = 0.05, .grid = 3});
    const double expected = dense_eta(walk.graph, walk.truth);
    REQUIRE(expected > 0.0);
    for (const int robots : {1, 2, 5}) {
      const Certificate found = certify(cut_into_robots(walk.graph, robots), walk.truth);
      CAPTURE(dimension, robots);
      CHECK(found.eta >= expected * (1.0 - 1e-6));
      CHECK(found.eta <= expected * 1.0201);
      CHECK(found.cost == Approx(cost(walk.graph, walk.truth)));
      CHECK((found.bytes > 0) == (robots > 1));
      CHECK((found.separator > 0) == (robots > 1));
    }
  }
}

TEST_CASE("an optimum is certified, and no cost is below the bound of what is none") {
  for (const int dimension : {2, 3}) {
    const Walk walk = make_walk({.dimension = dimension, .poses = 150, .rotation_sigma = 0.02});
    const CentralResult optimum = solve_least_squares(walk.graph, chordal_start(walk.graph));
    const PoseGraph team = cut_into_robots(walk.graph, 3);
    CHECK(certify(walk.graph, optimum.poses).gap <= 1e-7);
    CHECK(certify(team, optimum.poses).gap <= 1e-7);
    for (const Poses& candidate : {walk.truth, chordal_start(walk.graph)}) {
      const Certificate certificate = certify(walk.graph, candidate);
      CAPTURE(dimension, certificate.gap, certificate.cost, optimum.cost);
      CHECK(certificate.lower_bound <= optimum.cost);
      CHECK(certificate.gap >= 1.0 - optimum.cost / certificate.cost);
    }
  }
}

TEST_CASE("a planted local minimum is told from the optimum, by a robot and by a team alike") {
  for (const int dimension : {2, 3}) {
    const Ring ring = make_ring(dimension, 30, 1);
    const CentralResult optimum = solve_least_squares(ring.graph, chordal_start(ring.graph));
    const CentralResult local = solve_least_squares(ring.graph, ring.wound, {.max_iterations = 20000});
    CAPTURE(local.message, local.iterations, local.cost, optimum.cost);
    REQUIRE(local.converged);
    REQUIRE(local.cost > 1.5 * optimum.cost);
    const Certificate central = certify(ring.graph, local.poses);
    const double true_gap = 1.0 - optimum.cost / local.cost;
    CAPTURE(dimension, optimum.cost, local.cost, central.gap);
    CHECK(central.gap >= true_gap);
    CHECK(central.eta == Approx(dense_eta(ring.graph, local.poses)).epsilon(0.02));
    CHECK(central.gap == Approx(central.eta * dimension * 30 / local.cost).epsilon(1e-3));
    CHECK(certify(ring.graph, optimum.poses).gap < 1e-6);
    for (const int robots : {2, 5}) {
      const Certificate distributed = certify(cut_into_robots(ring.graph, robots), local.poses);
      CHECK(distributed.gap == Approx(central.gap).epsilon(0.02));
      CHECK(distributed.bytes > 0);
    }
  }
}

TEST_CASE("edges of weight 0 are not there, others count by their weight, and parts may come apart") {
  const Walk walk = make_walk({.poses = 60, .rotation_sigma = 0.02, .grid = 3});
  const Injection injection = inject_outliers(cut_into_robots(walk.graph, 3), 0.3, 2);
  std::vector<double> weights;
  for (const bool is_true : injection.is_true) weights.push_back(is_true ? 1.0 : 0.0);
  const CentralResult optimum = solve_least_squares(walk.graph, chordal_start(walk.graph));
  CHECK(certify(injection.graph, optimum.poses, weights).gap <= 1e-7);
  CHECK(certify(injection.graph, optimum.poses).gap > 0.5);

  PoseGraph half = injection.graph;
  for (std::size_t e = 0; e < half.edges.size(); ++e) {
    half.edges[e].kappa *= 2.0;
    half.edges[e].tau *= 2.0;
    weights[e] *= 0.5;
  }
  CHECK(certify(half, optimum.poses, weights).cost == Approx(optimum.cost));
  CHECK(certify(half, optimum.poses, weights).gap <= 1e-7);

  // Without any loop between robots each has an optimum of its own, and a gauge of its own.
  for (std::size_t e = 0; e < half.edges.size(); ++e) {
    if (half.edges[e].between_robots()) weights[e] = 0.0;
  }
  const Certificate apart = certify(half, walk.truth, weights);
  CHECK(apart.separator == 0);
  CHECK(apart.gap == Approx(certify(as_one_robot(half), walk.truth, weights).gap).epsilon(0.03));
}

TEST_CASE("graphs without freedom or without noise are certified, too") {
  const PoseGraph one{3, {1}, {}};
  CHECK(certify(one, {SE3{}}).gap < 1e-7);
  const PoseGraph two{2, {2}, {{{0, 0}, {0, 1}, SE3{SO3{}, {1, 0, 0}}, 1, 1, EdgeKind::kOdometry, true}}};
  const Poses exact = {SE3{}, SE3{SO3{}, {1, 0, 0}}};
  CHECK(certify(two, exact).gap < 1e-6);
  CHECK(certify(cut_into_robots(two, 2), exact).gap < 1e-6);
}

TEST_CASE("optima of published graphs are certified") {
  for (const std::string name : {"tinyGrid3D", "smallGrid3D", "intel"}) {
    const auto file = test_data("pose_graphs/" + name + ".g2o");
    if (!file) return;
    const PoseGraph graph = read_g2o(*file).graph;
    const CentralResult optimum =
        solve_least_squares(graph, chordal_start(graph), {.relative_cost_tolerance = 1e-14});
    CAPTURE(name);
    CHECK(certify(graph, optimum.poses).gap <= 1e-6);
    CHECK(certify(cut_into_robots(graph, 3), optimum.poses).gap <= 1e-6);
  }
}
