// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The pose graph that pgo solves, made from files by the definitions of procs/pgo/README.md.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/pgo/pose_graph.h"

namespace covey {

struct ProblemOptions {
  std::filesystem::path graph;
  std::string world;  // made up instead of read: "stata"
  int robots = 0;     // 0: one for a g2o file, what they say for robot files
  double outliers = 0.0;
  std::uint64_t seed = 1;
  std::filesystem::path reference;
  std::filesystem::path true_loops;
};

struct Problem {
  pgo::PoseGraph graph;
  pgo::PoseGraph without_outliers;      // the graph without the edges that are known to be wrong
  std::vector<bool> is_true;            // per edge of graph
  bool truth_known = false;             // is_true means something: outliers were added, or listed
  std::optional<Trajectory> reference;  // by stamps of to_trajectory
};

// Throws InputError; warnings go to stderr.
Problem load_problem(const ProblemOptions& options);

// Poses in flat order as a trajectory: the pose of flat index k at k + 1 seconds.
Trajectory to_trajectory(const pgo::Poses& poses);

}  // namespace covey
