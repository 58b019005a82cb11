// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/edge_factors.h"

#include "core/geometry/se2.h"
#include "core/graph/pose_factors.h"

namespace covey::pgo {
namespace {

SE2 planar_part(const SE3& T) { return {T.rotation.log().z(), T.translation.head<2>()}; }

SE3 spatial(const SE2& T) {
  return {SO3::exp({0.0, 0.0, T.angle}), {T.translation.x(), T.translation.y(), 0.0}};
}

}  // namespace

graph::FactorId add_edge(graph::Graph& graph, const Edge& edge, int dimension, graph::Key from,
                         graph::Key to) {
  if (dimension == 2) {
    return graph.add(graph::ChordalBetween2{planar_part(edge.measurement), edge.kappa, edge.tau}, {from, to});
  }
  return graph.add(graph::ChordalBetween3{edge.measurement, edge.kappa, edge.tau}, {from, to});
}

void set_pose(graph::Values& values, graph::Key key, const SE3& T, int dimension) {
  if (dimension == 2) {
    values.set(key, planar_part(T));
  } else {
    values.set(key, T);
  }
}

SE3 get_pose(const graph::Values& values, graph::Key key) {
  if (values.type(key).space == graph::Space::kSE2) return spatial(values.get<SE2>(key));
  return values.get<SE3>(key);
}

}  // namespace covey::pgo
