// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a solution of a pose graph is worth: the least-squares cost and the robust cost of CONVENTIONS.md, and
// how well loops were told from outliers. Both costs are sums without a factor 1/2, and hold for any gauge.

#include <vector>

#include "core/pgo/edge_noise.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

// kappa |R_B - R_A R_AB|_F^2 + tau |t_B - t_A - R_A t_AB|^2
double squared_residual(const SE3& T_A_B, const Precision& precision, const SE3& T_W_A, const SE3& T_W_B);
double squared_residual(const Edge& edge, const SE3& T_from, const SE3& T_to);
std::vector<double> squared_residuals(const PoseGraph& graph, const Poses& poses);  // per edge

double cost(const PoseGraph& graph, const Poses& poses);

// sum over known inliers of r^2 + sum over the others of min(r^2, barc2), with the r^2 of robust_form(graph);
// it is called here, so pass the graph as it was read.
struct RobustCost {
  double cost = 0.0;
  int kept_loops = 0;  // loops with r^2 <= barc2, and those that are known inliers
  int loops = 0;
  std::vector<bool> kept;  // per edge
};
RobustCost robust_cost(const PoseGraph& graph, const Poses& poses, double barc2);

// kept and is_true per edge; only loops count. Precision is 1 when nothing was kept, recall 1 when nothing
// was true.
struct LoopScore {
  double precision = 1.0;  // part of the kept loops that are true
  double recall = 1.0;     // part of the true loops that were kept
};
LoopScore score_loops(const PoseGraph& graph, const std::vector<bool>& kept,
                      const std::vector<bool>& is_true);

}  // namespace covey::pgo
