// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A team's least squares by second-order steps, in one process: one SchurBlock per robot (schur.h), messages handed over directly.
// The lowest robot with poses solves for the separating ones; its first pose is held where the start has it, which fixes the
// gauge. The graph need not be connected: then each part stays about where it starts.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/pgo/pose_graph.h"
#include "core/pgo/schur.h"

namespace covey::pgo {

// The robots that have poses, ascending. `start` is in one frame; the places of schur_key() are the poses' indices.
struct SchurMember {
  SchurBlock block;
  std::vector<std::size_t> edges;  // of the graph, by the FactorId of the block's graph
};
std::vector<SchurMember> schur_members(const PoseGraph& graph, const Poses& start,
                                       const SchurOptions& options = {});
Poses gather_poses(const PoseGraph& graph, const std::vector<SchurMember>& members);

struct SolveSchurOptions {
  SchurOptions step;
  int max_rounds = 100;
  double tolerance = 1e-11;  // ends when a step promises less than this part of the cost
  std::function<bool(const std::function<Poses()>&)> stop;  // asked after each round
};

struct SolveSchurResult {
  Poses poses;
  double cost = 0.0;  // by cost.h
  bool converged = false;
  int rounds = 0;                             // steps, each of all robots
  int block_updates = 0;                      // rounds of each robot that has poses
  std::vector<double> costs;                  // where each step began
  int separating_poses = 0;                   // of all robots together
  std::map<std::string, std::int64_t> bytes;  // encoded messages by type, each broadcast counted once
};

SolveSchurResult solve_schur(const PoseGraph& graph, const Poses& start,
                             const SolveSchurOptions& options = {});

}  // namespace covey::pgo
