// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Edges and poses of a pose graph as factors and variables of core/graph: SE3, or SE2 where the graph is planar.

#include "core/graph/graph.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

// The factor whose |r|^2 is the edge's squared residual (cost.h).
graph::FactorId add_edge(graph::Graph& graph, const Edge& edge, int dimension, graph::Key from,
                         graph::Key to);

void set_pose(graph::Values& values, graph::Key key, const SE3& T, int dimension);
SE3 get_pose(const graph::Values& values, graph::Key key);

}  // namespace covey::pgo
