// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/graph_score.h"

namespace covey {

GraphScore score_graph(const pgo::PoseGraph& graph, const GraphSolution& solution, double barc2,
                       const std::optional<pgo::Poses>& truth, const ClosureLimits& limits) {
  GraphScore score;
  score.robust = pgo::robust_cost(graph, solution.poses, barc2);
  const std::vector<bool>& kept = solution.kept ? *solution.kept : score.robust.kept;
  const std::vector<int> offsets = graph.offsets();
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    const pgo::Edge& edge = graph.edges[e];
    if (edge.kind != pgo::EdgeKind::kLoop) continue;
    JudgedClosure closure{edge.from.robot, edge.to.robot, kept[e], std::nullopt};
    if (truth) {
      const SE3& T_W_A = (*truth)[offsets[edge.from.robot] + edge.from.index];
      const SE3& T_W_B = (*truth)[offsets[edge.to.robot] + edge.to.index];
      closure.right = is_right_closure(edge.measurement, T_W_A.inverse() * T_W_B, limits);
    }
    score.closures.push_back(closure);
  }
  score.loops = score_loops(score.closures, graph.robots());
  return score;
}

}  // namespace covey
