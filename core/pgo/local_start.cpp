// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/local_start.h"

namespace covey::pgo {
namespace {

// The segment as the pose graph of one robot. Planar segments stay planar: no residual leaves the plane.
PoseGraph graph_of(const GraphSnapshot& graph, const Segment& segment) {
  PoseGraph local{3, {static_cast<int>(segment.poses.size())}, {}};
  for (int k = 1; k < static_cast<int>(segment.poses.size()); ++k) {
    const OdometryPose& pose = segment.poses[k];
    local.edges.push_back({{0, k - 1},
                           {0, k},
                           pose.T_P_K,
                           pose.precision.kappa,
                           pose.precision.tau,
                           EdgeKind::kOdometry,
                           true});
  }
  for (const GraphLoop& loop : graph.private_loops) {
    if (loop.a.segment != segment.name || loop.b.segment != segment.name) continue;
    local.edges.push_back({{0, loop.a.id},
                           {0, loop.b.id},
                           loop.T_A_B,
                           loop.precision.kappa,
                           loop.precision.tau,
                           EdgeKind::kLoop,
                           loop.known_inlier});
  }
  return local;
}

}  // namespace

void solve_odometry_starts(const GraphSnapshot& graph, const RobustOptions& options,
                           std::vector<SegmentStart>& starts) {
  for (std::size_t s = 0; s < graph.segments.size(); ++s) {
    if (starts[s].solution != 0) continue;
    const PoseGraph local = graph_of(graph, graph.segments[s]);
    if (local.loops() == 0) continue;
    starts[s].T_S_K = solve_robust(local, starts[s].T_S_K, options).poses;
  }
}

}  // namespace covey::pgo
