// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/pcm_selection.h"

#include <fmt/format.h>

#include <cstdio>
#include <ctime>
#include <utility>

#include "core/pgo/cost.h"

namespace covey {

PcmSelection select_consistent(const pgo::PoseGraph& graph, const SolverOptions& options) {
  pgo::PcmOptions pcm{.barc2 = options.barc2};
  pcm.clique.clock = [] { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  PcmSelection selection;
  selection.pcm = pgo::consistent_loops(graph, pcm);
  selection.graph = pgo::keep_edges(graph, selection.pcm.kept);
  for (const pgo::PcmGroup& group : selection.pcm.groups) {
    if (group.exact) continue;
    fmt::print(stderr,
               "pgo: pcm, robots {} and {}: after {:.1f} s the largest clique of {} loops that was found has "
               "{}; there may "
               "be larger ones\n",
               group.a, group.b, group.seconds, group.loops, group.kept);
  }
  return selection;
}

Solution of_whole_graph(Solution solution, const PcmSelection& selection, const pgo::PoseGraph& graph,
                        double barc2) {
  const std::vector<bool>& selected = selection.pcm.kept;
  solution.kept = pgo::robust_cost(graph, solution.poses, barc2).kept;
  std::vector<double> weights(selected.size(), 0.0);
  for (std::size_t e = 0, k = 0; e < selected.size(); ++e) {
    solution.kept[e] = solution.kept[e] && selected[e];
    if (selected[e]) weights[e] = solution.weights[k++];
  }
  solution.weights = std::move(weights);
  return solution;
}

}  // namespace covey
