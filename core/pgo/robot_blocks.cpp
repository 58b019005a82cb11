// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/robot_blocks.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace covey::pgo {
namespace {

struct Parts {
  std::vector<PrivateEdge> edges;
  std::vector<SharedEdge> shared;
  std::vector<PoseId> others;  // at the other ends of shared edges
  std::vector<int> public_poses;
};

void sort_once(std::vector<int>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

int place_in(const std::vector<int>& sorted, int value) {
  return static_cast<int>(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin());
}

}  // namespace

std::vector<RobotBlock> split_into_blocks(const PoseGraph& graph, int rank,
                                          const BlockSolverOptions& options) {
  std::vector<Parts> parts(graph.robots());
  for (const Edge& edge : graph.edges) {
    const PoseId& a = edge.from;
    const PoseId& b = edge.to;
    if (!edge.between_robots()) {
      parts[a.robot].edges.push_back({a.index, b.index, edge.measurement, edge.kappa, edge.tau});
      continue;
    }
    for (const bool mine_is_from : {true, false}) {
      const PoseId& mine = mine_is_from ? a : b;
      Parts& part = parts[mine.robot];
      part.shared.push_back({mine.index, mine_is_from, edge.measurement, edge.kappa, edge.tau});
      part.others.push_back(mine_is_from ? b : a);
      part.public_poses.push_back(mine.index);
    }
  }
  std::vector<int> block_of(graph.robots(), -1);
  int n = 0;
  for (int robot = 0; robot < graph.robots(); ++robot) {
    sort_once(parts[robot].public_poses);
    if (graph.poses_per_robot[robot] > 0) block_of[robot] = n++;
  }
  const std::vector<int> offsets = graph.offsets();
  std::vector<RobotBlock> blocks;
  for (int robot = 0; robot < graph.robots(); ++robot) {
    if (block_of[robot] < 0) continue;
    Parts& part = parts[robot];
    std::vector<SharedEnd> ends;
    std::vector<int> neighbours;
    for (const PoseId& other : part.others) {
      ends.push_back({block_of[other.robot], place_in(parts[other.robot].public_poses, other.index)});
      neighbours.push_back(block_of[other.robot]);
    }
    sort_once(neighbours);
    blocks.push_back({robot, offsets[robot],
                      BlockSolver(graph.poses_per_robot[robot], rank, std::move(part.edges),
                                  std::move(part.shared), options),
                      part.public_poses, std::move(ends), std::move(neighbours)});
  }
  return blocks;
}

Lifted public_part(const RobotBlock& block, const Lifted& X) {
  const auto m = static_cast<Eigen::Index>(block.public_poses.size());
  Lifted part(X.rows(), 4 * m);
  for (Eigen::Index k = 0; k < m; ++k) part.middleCols<4>(4 * k) = X.middleCols<4>(4 * block.public_poses[k]);
  return part;
}

Lifted targets_of(const RobotBlock& block, const std::vector<Lifted>& public_poses) {
  Lifted targets(block.solver.rank(), 4 * static_cast<Eigen::Index>(block.ends.size()));
  for (std::size_t e = 0; e < block.ends.size(); ++e) {
    const SharedEnd& end = block.ends[e];
    targets.middleCols<4>(4 * static_cast<Eigen::Index>(e)) =
        other_side(block.solver.shared()[e], public_poses[end.block].middleCols<4>(4 * end.place));
  }
  return targets;
}

std::vector<int> colours_of(const std::vector<RobotBlock>& blocks) {
  std::vector<int> order(blocks.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return blocks[a].neighbours.size() > blocks[b].neighbours.size(); });
  std::vector<int> colours(blocks.size(), -1);
  for (const int block : order) {
    const auto taken = [&](int colour) {
      return std::any_of(blocks[block].neighbours.begin(), blocks[block].neighbours.end(),
                         [&](int other) { return colours[other] == colour; });
    };
    int colour = 0;
    while (taken(colour)) ++colour;
    colours[block] = colour;
  }
  return colours;
}

}  // namespace covey::pgo
