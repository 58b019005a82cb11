// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A smallest set of vertices of a bipartite graph that touches each of its edges, by Koenig's theorem from a largest matching. It
// depends on the set of edges alone, not on their order, so that two robots find the same for the loops between them.
// Source: Koenig, "Graphs and matrices", Matematikai es Fizikai Lapok 1931; augmenting paths: Kuhn, 1955.

#include <set>
#include <utility>
#include <vector>

#include "core/graph/key.h"

namespace covey::pgo {

// The first end of each edge lies on one side of the graph, the second on the other.
std::set<graph::Key> vertex_cover(const std::vector<std::pair<graph::Key, graph::Key>>& edges);

}  // namespace covey::pgo
