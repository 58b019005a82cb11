// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/cost.h"

#include <algorithm>
#include <numeric>

#include "core/base/error.h"

namespace covey::pgo {

double squared_residual(const SE3& T_A_B, const Precision& precision, const SE3& T_W_A, const SE3& T_W_B) {
  // |R_B - R_A R_AB|_F^2 = |I - E|_F^2 = 8 sin^2(angle / 2) with E = (R_A R_AB)^-1 R_B, whose quaternion's vector part has the
  // norm sin(angle / 2). This keeps small angles to full precision.
  const SO3 E = (T_W_A.rotation * T_A_B.rotation).inverse() * T_W_B.rotation;
  const Eigen::Vector3d dt = T_W_B.translation - T_W_A * T_A_B.translation;
  return 8.0 * precision.kappa * E.quaternion().vec().squaredNorm() + precision.tau * dt.squaredNorm();
}

double squared_residual(const Edge& edge, const SE3& T_from, const SE3& T_to) {
  return squared_residual(edge.measurement, {edge.kappa, edge.tau}, T_from, T_to);
}

std::vector<double> squared_residuals(const PoseGraph& graph, const Poses& poses) {
  COVEY_CHECK(static_cast<int>(poses.size()) == graph.poses());
  const std::vector<int> offsets = graph.offsets();
  std::vector<double> r2;
  r2.reserve(graph.edges.size());
  for (const Edge& edge : graph.edges) {
    r2.push_back(squared_residual(edge, poses[offsets[edge.from.robot] + edge.from.index],
                                  poses[offsets[edge.to.robot] + edge.to.index]));
  }
  return r2;
}

double cost(const PoseGraph& graph, const Poses& poses) {
  const std::vector<double> r2 = squared_residuals(graph, poses);
  return std::accumulate(r2.begin(), r2.end(), 0.0);
}

RobustCost robust_cost(const PoseGraph& graph, const Poses& poses, double barc2) {
  const std::vector<double> r2 = squared_residuals(robust_form(graph), poses);
  RobustCost result;
  for (std::size_t e = 0; e < r2.size(); ++e) {
    const Edge& edge = graph.edges[e];
    const bool kept = edge.known_inlier || r2[e] <= barc2;
    result.kept.push_back(kept);
    result.cost += kept ? r2[e] : barc2;
    if (edge.kind != EdgeKind::kLoop) continue;
    ++result.loops;
    result.kept_loops += kept ? 1 : 0;
  }
  return result;
}

LoopScore score_loops(const PoseGraph& graph, const std::vector<bool>& kept,
                      const std::vector<bool>& is_true) {
  COVEY_CHECK(kept.size() == graph.edges.size() && is_true.size() == graph.edges.size());
  int all_kept = 0;
  int all_true = 0;
  int both = 0;
  for (std::size_t e = 0; e < kept.size(); ++e) {
    if (graph.edges[e].kind != EdgeKind::kLoop) continue;
    all_kept += kept[e] ? 1 : 0;
    all_true += is_true[e] ? 1 : 0;
    both += kept[e] && is_true[e] ? 1 : 0;
  }
  LoopScore score;
  if (all_kept > 0) score.precision = static_cast<double>(both) / all_kept;
  if (all_true > 0) score.recall = static_cast<double>(both) / all_true;
  return score;
}

}  // namespace covey::pgo
