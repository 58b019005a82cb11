// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A team's pose graph solved by the distributed solver in one process: one DgncRound per robot, messages handed over
// directly. The same computation as over the radio, where messages arrive later.
//
// Each robot's poses that consecutive odometry edges join are a segment; further odometry edges between the same poses
// become loops with weight 1. With options.robust = false this is plain distributed least squares. `graph` in robust_form
// for robust solving (pose_graph.h).

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/pgo/dgnc_options.h"
#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct DistributedProgress {
  int updates = 0;  // of each robot
  double mu = 0.0;
  std::function<Poses()> poses;  // rounded, all in W
};

struct DistributedOptions {
  DgncOptions dgnc;
  std::optional<Poses>
      start;  // in one frame; without it each robot starts from its odometry and frames are aligned
  std::function<bool(const DistributedProgress&)> stop;  // asked after each update of all robots
};

struct DistributedResult {
  Poses poses;                  // T_W_pose in flat order; identity for robots without a place in W
  std::vector<bool> placed;     // per pose: connected to the frame of the first robot
  std::vector<double> weights;  // per edge
  double cost = 0.0;            // of the edges among placed poses; robust as in CONVENTIONS.md
  int kept = 0;                 // loops with weight 1
  int stages = 0;
  int updates = 0;                            // of each robot
  int block_updates = 0;                      // of all robots
  int messages = 0;                           // per robot: the message delays of a run over the radio
  std::map<std::string, std::int64_t> bytes;  // encoded messages by type, each broadcast counted once
  std::vector<std::string> warnings;
};

DistributedResult solve_distributed(const PoseGraph& graph, const DistributedOptions& options = {});

}  // namespace covey::pgo
