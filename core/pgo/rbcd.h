// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Riemannian block-coordinate descent (RBCD) on a team's pose graph: least squares, one block of variables per robot, all
// robots in one process. A block update is one robot minimising over its own poses with the others' held where they were last
// said to be (block_solver.h); then it tells its public poses. Poses are lifted to St(r, 3) x R^r; planar ones stay planar.
//
// Who is next:
//   greedy        the robot whose block's gradient is largest; each tells its gradient's norm when it has changed
//   round-robin   one after the other
//   coloured      robots without edges between them share a colour; colours one after the other, those of one at the same time
//   asynchronous  any robot at any time (drawn by the seed), from poses of its neighbours that are up to max_delay updates old
//                 (Tian, Koppel, Bedi, How, "Asynchronous and Parallel Distributed Pose Graph Optimization", RA-L 2020)
//
// Acceleration. After each round (as many updates as robots) the team goes on along the directions of this and earlier rounds
// (extrapolation.h). Where that does not lower the team's cost it is taken back and begins anew without memory. So but for
// asynchronous updates the team's cost never rises; with poses of the past no robot can know it, and the step is not used.
//
// Public poses travel as 16-bit differences to what was sent before (public_poses.h). A robot's own public poses are moved to
// what it has sent, so that all mean the same numbers, and an update that does not lower its cost even so is not sent.
//
// Source: Tian, Khosoussi, Rosen, How, "Distributed Certifiably Correct Pose-Graph Optimization", T-RO 2021, algorithms 2-4.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/pgo/block_solver.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

enum class Schedule { kGreedy, kRoundRobin, kColoured, kAsynchronous };

// greedy, round-robin, coloured, asynchronous.
const std::map<std::string, Schedule>& schedules();

struct RbcdProgress {
  int block_updates = 0;
  int rounds = 0;
  double cost = 0.0;             // of the lifted poses; that of the rounded ones is not smaller
  std::int64_t bytes_sent = 0;   // so far
  std::function<Poses()> poses;  // rounded
};

struct RbcdOptions {
  Schedule schedule = Schedule::kColoured;
  bool accelerated = true;
  int memory = 2;  // earlier rounds whose displacements the acceleration uses
  int rank = 5;
  std::uint64_t seed = 1;  // asynchronous: who is next, and how old what it knows is
  int max_delay = 10;      // asynchronous: updates of the team
  // Ends when a round (asynchronous: as many rounds as the delay spans, and one) changes the cost by less than this part of it.
  double tolerance = 1e-9;
  int max_block_updates = 20000;
  BlockSolverOptions block{.max_outer = 1, .max_inner = 10, .inner_tolerance = 0.1};
  std::function<bool(const RbcdProgress&)> stop = nullptr;  // asked after each block update
};

struct RbcdUpdate {  // evidence of one block update
  int robot = 0;
  double cost_before = 0.0;  // the team's
  double cost_after = 0.0;
  double gradient = 0.0;  // norm of the block's gradient before, by what the robot knew
  bool sent = true;       // false: it gained nothing
};

struct RbcdResult {
  Poses poses;        // in the frame where the first pose is where the start had it
  double cost = 0.0;  // of the lifted poses
  bool converged = false;
  int block_updates = 0;
  int rounds = 0;  // block updates by the number of robots, rounded up
  int steps = 0;   // one after the other: those of one colour are one
  int accelerations = 0;
  int taken_back = 0;                         // of these
  std::map<std::string, std::int64_t> bytes;  // encoded messages by kind, each broadcast counted once
  std::vector<RbcdUpdate> updates;
};

// `start` in flat order, all poses in one frame; the graph must be connected.
RbcdResult solve_rbcd(const PoseGraph& graph, const Poses& start, const RbcdOptions& options = {});

}  // namespace covey::pgo
