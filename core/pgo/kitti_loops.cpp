// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/kitti_loops.h"

#include <limits>
#include <map>
#include <utility>

#include "core/pgo/fields.h"
#include "core/pgo/start.h"

namespace covey::pgo {

std::vector<bool> read_true_loops(const std::filesystem::path& file, const G2oFile& graph) {
  std::vector<bool> is_true(graph.graph.edges.size(), false);
  std::multimap<std::pair<long, long>, std::size_t> loops;  // by ids
  for (std::size_t e = 0; e < is_true.size(); ++e) {
    const Edge& edge = graph.graph.edges[e];
    is_true[e] = edge.kind == EdgeKind::kOdometry;
    if (!is_true[e]) loops.emplace(std::pair(graph.ids[edge.from.index], graph.ids[edge.to.index]), e);
  }
  constexpr long kMaxId = std::numeric_limits<long>::max();
  for (FieldReader line(file, ' '); line.next();) {
    if (line.size() != 2) line.refuse("has {} fields, not the two vertex ids of a true loop", line.size());
    const std::pair ids(line.whole(0, "vertex id", 0, kMaxId), line.whole(1, "vertex id", 0, kMaxId));
    const auto [begin, end] = loops.equal_range(ids);
    if (begin == end) line.refuse("the graph has no loop from vertex {} to vertex {}", ids.first, ids.second);
    for (auto loop = begin; loop != end; ++loop) is_true[loop->second] = true;
  }
  return is_true;
}

Poses read_truth(const std::filesystem::path& file) {
  const G2oFile g2o = read_g2o(file);
  if (g2o.start) return *g2o.start;
  if (g2o.graph.loops() > 0 || static_cast<int>(g2o.graph.edges.size()) != g2o.graph.poses() - 1) {
    throw_input_error(
        "{}: has no VERTEX line for each pose, and its edges are not one chain, so it is no reference",
        file.string());
  }
  return odometry_start(g2o.graph);
}

}  // namespace covey::pgo
