// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a round leaves with each of its members: its poses in W, its loops with their weights, and evidence of how it went.

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <map>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/rejected_pairs.h"

namespace covey::pgo {

struct SegmentResult {
  Utime segment = 0;
  bool placed = false;  // connected to W
  std::vector<SE3> T_W_K;
};

struct StageResult {      // between two changes of the weights
  double mu = 0.0;        // infinite for binary weights
  int updates = 0;        // of each robot
  double cost = 0.0;      // of the part, weighted, before the stage's last update
  double gradient = 0.0;  // norm of its Riemannian gradient there
  int weights_zero = 0;   // own loops: private, or shared with a higher robot
  int weights_between = 0;
  int weights_one = 0;
  std::int64_t bytes = 0;  // sent by this robot since the stage before, as encoded
};

struct RoundResult {  // of this robot
  RoundName name;
  int anchor = 0;           // of this robot's part of the team: W is its O
  std::int64_t frame = 0;   // name of W
  std::vector<int> robots;  // of that part
  std::vector<SegmentResult> segments;
  std::vector<LoopResult> loops;  // private and shared
  std::uint64_t graph = 0;        // hash of what was solved
  int keyframes = 0;
  int loops_used = 0;  // loops.size() minus those that only one end knew
  int loops_kept = 0;  // with weight 1
  int owned_kept = 0;  // of these: private, or shared with a higher robot
  double owned_cost =
      0.0;  // odometry r2 + min(r2, barc2) over private loops and those shared with a higher robot; sums to the team's
  int stages = 0;
  int updates = 0;
  double gradient = 0.0;  // norm of the part's Riemannian gradient before the last update
  int weights_zero = 0;   // own loops: private, or shared with a higher robot
  int weights_between = 0;
  int weights_one = 0;
  std::int64_t bytes = 0;  // that this robot sent in the round, as encoded
  std::vector<StageResult> stage_results;
  std::vector<std::string> rejected;  // sentences on pairs of robots none of whose closures were kept
  std::vector<std::string> warnings;
};

// Where the solver of an agreed problem has come to.
struct RoundSolution {
  std::vector<SE3> T_root_K;                        // own poses
  std::map<int, std::vector<SE3>> T_root_K_public;  // of each robot of the part, as all know them
  Eigen::VectorXd private_weights;                  // in the order of graph.private_loops
  Eigen::VectorXd shared_weights;                   // in the order of ends
};

std::vector<SegmentResult> placed_segments(const AgreedProblem& problem, const std::vector<SE3>& T_root_K);

// All but stages, updates, gradient and bytes. barc2: infinite for plain least squares. Warns of pairs of robots none of whose loops
// were kept, of loops that alone join two parts of the team, and of segments without a place in W.
RoundResult round_result(const AgreedProblem& problem, const RoundSolution& solution, double barc2);

// Its pieces, for whoever comes to poses and weights another way. Counts a loop, and its cost where this robot owns it.
void add_loop(const LoopResult& loop, bool owned, double barc2, RoundResult& result);
void add_warnings(const AgreedProblem& problem, double barc2, RoundResult& result);

}  // namespace covey::pgo
