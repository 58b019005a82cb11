// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A team's pose graph as block-coordinate descent sees it: one block of variables per robot, and of the other robots nothing
// but their public poses, those at the ends of edges between robots. Robots without poses have no block; blocks are numbered
// in the order of their robots.

#include <vector>

#include "core/pgo/block_solver.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct SharedEnd {  // the other end of a shared edge
  int block = 0;
  int place = 0;  // among that block's public poses
};

struct RobotBlock {
  int robot = 0;
  int first = 0;  // flat index of its first pose
  BlockSolver solver;
  std::vector<int> public_poses;  // indices in the block, ascending
  std::vector<SharedEnd> ends;    // of solver.shared(), in that order
  std::vector<int> neighbours;    // blocks at those ends, ascending
};

std::vector<RobotBlock> split_into_blocks(const PoseGraph& graph, int rank,
                                          const BlockSolverOptions& options);

// The public ones of a block's poses, r x 4m.
Lifted public_part(const RobotBlock& block, const Lifted& X);
// What a block minimises against, r x 4 per shared edge, from all blocks' public poses.
Lifted targets_of(const RobotBlock& block, const std::vector<Lifted>& public_poses);

// A colour for each block, 0, 1, ..., different for neighbours; the blocks with most neighbours choose first (Welsh and Powell,
// "An upper bound for the chromatic number of a graph", 1967).
std::vector<int> colours_of(const std::vector<RobotBlock>& blocks);

}  // namespace covey::pgo
