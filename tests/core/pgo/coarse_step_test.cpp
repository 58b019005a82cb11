// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/coarse_step.h"

#include <catch2/catch.hpp>

namespace covey::pgo {
namespace {

constexpr int kChain = 41;
constexpr double kStride = 0.5;  // m

// One segment straight ahead, three of its keyframes public.
AgreedProblem three_nodes() {
  AgreedProblem problem;
  problem.part = {0};
  problem.graph.segments = {{7, std::vector<OdometryPose>(kChain)}};
  OpenedMember& self = problem.members[0];
  self.join.n_segments = 1;
  self.join.segments = {7};
  for (const int id : {0, 20, 40}) {
    self.places[{0, id}] = static_cast<int>(self.T_S_K.size());
    self.segments.push_back(0);
    self.T_S_K.push_back({SO3{}, {kStride * id, 0.0, 0.0}});
  }
  return problem;
}

BlockSolver straight_chain() {
  std::vector<PrivateEdge> edges;
  for (int k = 1; k < kChain; ++k) edges.push_back({k - 1, k, {SO3{}, {kStride, 0.0, 0.0}}, 1e4, 1e2});
  return {kChain, 3, std::move(edges), {}};
}

// The chain with its nodes moved, the keyframes between them as they lie.
Lifted bent_chain() {
  const std::vector<Eigen::Vector3d> steps = {
      Eigen::Vector3d::Zero(), {0.0, 0.1, 0.02}, {0.05, 0.3, -0.01}};  // x, y, angle
  Lifted X(3, 4 * kChain);
  for (int k = 0; k < kChain; ++k) {
    const int before = std::min(k / 20, 1);
    const double part = k / 20.0 - before;
    SE3 pose{SO3{}, {kStride * k, 0.0, 0.0}};
    double angle = 0.0;
    for (const auto& [node, share] : {std::pair(before, 1.0 - part), std::pair(before + 1, part)}) {
      angle += share * steps[node].z();
      pose.translation.head<2>() += share * steps[node].head<2>();
      pose.translation.y() += share * steps[node].z() * kStride * (k - 20 * node);
    }
    pose.rotation = SO3::exp({0.0, 0.0, angle});
    X.middleCols<4>(4 * k) = lift(pose, 3);
  }
  return X;
}

CoarseStep::Poses public_ones(const Lifted& X) {
  std::vector<SE3> poses;
  for (const int k : {0, 20, 40})
    poses.push_back({SO3::from_matrix(X.middleCols<3>(4 * k)), X.col(4 * k + 3)});
  return {{0, poses}};
}

dpgo_coarse_t coarse_message(const CoarseStep& coarse, const BlockSolver& solver, const Lifted& X) {
  dpgo_coarse_t m{};
  coarse.write_gradient(X, solver.riemannian_gradient(Lifted(3, 0), X), public_ones(X), m);
  coarse.write_hessian(solver, Eigen::VectorXd::Ones(kChain - 1), Eigen::VectorXd(0), X, public_ones(X), m);
  return m;
}

TEST_CASE("a wave that the nodes span is gone in one step, and the first node stays") {
  const AgreedProblem problem = three_nodes();
  const BlockSolver solver = straight_chain();
  CoarseStep coarse(problem);
  REQUIRE(coarse.useful());
  Lifted X = bent_chain();
  const CoarseStep::Poses before = public_ones(X);
  const double cost = solver.cost(Lifted(3, 0), X);
  const dpgo_coarse_t m = coarse_message(coarse, solver, X);
  REQUIRE(coarse.fits(0, m));
  REQUIRE(coarse.solve({{0, &m}}));
  coarse.move(before, X);
  CHECK(solver.cost(Lifted(3, 0), X) < 0.01 * cost);
  CHECK((X.col(4 * 40 + 3) - Eigen::Vector3d(kStride * 40, 0.0, 0.0)).norm() < 0.01);
  CHECK(X.col(3).norm() == 0.0);

  SECTION("public keyframes move as their robot moves them") {
    std::vector<SE3> poses = before.at(0);
    coarse.move(before, 0, poses);
    for (int k = 0; k < 3; ++k) CHECK((poses[k].translation - X.col(4 * 20 * k + 3)).norm() < 1e-9);
  }
}

TEST_CASE("messages of another number of nodes, or of nodes that there are not, are refused") {
  const AgreedProblem problem = three_nodes();
  const BlockSolver solver = straight_chain();
  CoarseStep coarse(problem);
  const dpgo_coarse_t good = coarse_message(coarse, solver, bent_chain());
  dpgo_coarse_t bad = good;
  bad.gradient.pop_back();
  CHECK_FALSE(coarse.fits(0, bad));
  bad = good;
  bad.rows.back() = 3;
  CHECK_FALSE(coarse.fits(0, bad));
  bad = good;
  bad.columns.front() = -1;
  CHECK_FALSE(coarse.fits(0, bad));
  bad = good;
  bad.values.pop_back();
  CHECK_FALSE(coarse.fits(0, bad));
  bad = good;
  bad.rows.clear();
  bad.columns.clear();
  bad.values.clear();
  bad.n_blocks = bad.n_values = 0;
  CHECK_FALSE(coarse.fits(0, bad));  // none before that could stand
  REQUIRE(coarse.solve({{0, &good}}));
  CHECK(coarse.fits(0, bad));
}

}  // namespace
}  // namespace covey::pgo
