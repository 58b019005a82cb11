// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/certificate.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/base/error.h"
#include "core/pgo/cost.h"
#include "core/pgo/shift_search.h"

namespace covey::pgo {
namespace {

constexpr double kLeastCostPerEdge = 1e-6;

PoseGraph weighted(const PoseGraph& graph, const std::vector<double>& weights) {
  PoseGraph result{graph.dimension, graph.poses_per_robot, {}};
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const double weight = weights.empty() ? 1.0 : weights[e];
    if (!(weight > 0.0)) continue;
    result.edges.push_back(graph.edges[e]);
    result.edges.back().kappa *= weight;
    result.edges.back().tau *= weight;
  }
  return result;
}

// Lambda_i, with a last row and column of zeros for the translation. A pose's needs its own edges only.
std::vector<PoseBlock> multipliers(const SeparatedGraph& team, const Poses& poses) {
  const int d = team.graph().dimension;
  std::vector<PoseBlock> lambda(poses.size(), PoseBlock::Zero(d + 1, d + 1));
  const auto add = [&](int pose, const PoseBlock& gradient) {
    lambda[pose].topLeftCorner(d, d) += 0.5 * (gradient + gradient.transpose());
  };
  for (const Edge& edge : team.graph().edges) {
    const int from = team.flat(edge.from);
    const int to = team.flat(edge.to);
    const PoseBlock R = rotation_of(edge.measurement, d);
    const PoseBlock R_from_to = rotation_of(poses[from].inverse() * poses[to], d);
    const Eigen::VectorXd t = translation_of(edge.measurement, d);
    const Eigen::VectorXd residual = translation_of(poses[from].inverse() * poses[to], d) - t;
    add(to, edge.kappa * (PoseBlock::Identity(d, d) - R_from_to.transpose() * R));
    add(from, edge.kappa * (PoseBlock::Identity(d, d) - R_from_to * R.transpose()) -
                  edge.tau * residual * t.transpose());
  }
  return lambda;
}

// The poses with the translations that are best for their rotations; solved for as a correction, which keeps precise what is nearly right.
Poses with_best_translations(const SeparatedGraph& team, Poses poses, std::int64_t& bytes) {
  const int d = team.graph().dimension;
  Eigen::MatrixXd descent = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(poses.size()), d);
  for (const Edge& edge : team.graph().edges) {
    const SE3& T_from = poses[team.flat(edge.from)];
    const SE3& T_to = poses[team.flat(edge.to)];
    const Eigen::Vector3d pull = edge.tau * (T_to.translation - T_from * edge.measurement.translation);
    descent.row(team.flat(edge.to)) -= pull.head(d);
    descent.row(team.flat(edge.from)) += pull.head(d);
  }
  TeamMatrix laplacian(team, 1, laplacian_blocks);
  if (!laplacian.factorise(Eigen::VectorXd::Zero(1)))
    return poses;  // too near to singular: they stay as they are
  for (int axis = 0; axis < d; ++axis) {
    const Eigen::VectorXd step = laplacian.solve(descent.col(axis));
    for (std::size_t k = 0; k < poses.size(); ++k)
      poses[k].translation[axis] += step[static_cast<Eigen::Index>(k)];
  }
  bytes += laplacian.bytes();
  return poses;
}

// What the robots tell each other beside complements: public poses before and translations after they are made best (those of
// the separator came with the solution), three sums each (cost, cost after that, largest eigenvalue of Lambda), each eta.
std::int64_t bytes_of_values(const SeparatedGraph& team, int trials) {
  if (team.parts().size() < 2) return 0;
  const int d = team.graph().dimension;
  const auto poses = static_cast<std::int64_t>(team.public_poses().size());
  const auto separator = static_cast<std::int64_t>(team.separator().size());
  const auto others = static_cast<std::int64_t>(team.parts().size()) - 1;
  return kBytesPerNumber * ((d == 2 ? 3 : 7) * poses + d * (poses - separator) + 3 * others + trials);
}

double largest_eigenvalue(const std::vector<PoseBlock>& blocks) {
  double largest = 0.0;
  for (const PoseBlock& block : blocks) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(block, Eigen::EigenvaluesOnly);
    largest = std::max(largest, eigen.eigenvalues().maxCoeff());
  }
  return largest;
}

}  // namespace

Certificate certify(const PoseGraph& graph, const Poses& poses, const std::vector<double>& weights,
                    const CertificateOptions& options) {
  COVEY_CHECK(static_cast<int>(poses.size()) == graph.poses());
  COVEY_CHECK(weights.empty() || weights.size() == graph.edges.size());
  const PoseGraph problem = weighted(graph, weights);
  const SeparatedGraph team(problem);
  const int d = graph.dimension;
  const double rotation_unknowns = static_cast<double>(d) * graph.poses();

  Certificate result;
  result.cost = cost(problem, poses);
  result.separator = static_cast<int>(team.separator().size());
  const Poses candidate = with_best_translations(team, poses, result.bytes);
  const std::vector<PoseBlock> lambda = multipliers(team, candidate);
  TeamMatrix S(team, d + 1, connection_blocks, lambda);

  const double scale =
      std::max(result.cost, kLeastCostPerEdge * static_cast<double>(problem.edges.size() + 1));
  ShiftSearch search(team, S);
  result.eta = search.find(options.resolution * scale / rotation_unknowns, largest_eigenvalue(lambda),
                           options.accuracy);
  result.trials = search.trials();
  result.lower_bound = cost(problem, candidate) - result.eta * rotation_unknowns;
  result.gap = (result.cost - result.lower_bound) / scale;
  result.bytes += S.bytes() + search.bytes() + bytes_of_values(team, result.trials);
  return result;
}

}  // namespace covey::pgo
