// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Pairs of robots of whose closures a round has kept none: with a lone closure that is the only link that was ever seen, so it
// never goes without a word. Each end of a pair says it, with the residuals, and with what it has kept instead.

#include <map>
#include <string>
#include <vector>

#include "core/pgo/robot_graph.h"

namespace covey::pgo {

struct LoopResult {
  GraphLoop loop;
  double weight = 0.0;
  double r2 = 0.0;
};

struct RejectedPair {
  int robot = 0;  // who says it
  int peer = 0;
  std::vector<LoopResult> loops;  // all between the two, ascending by residual
  std::map<int, int>
      kept;  // closures of `robot` with others that were kept, by the other one; with itself too
};

std::vector<RejectedPair> rejected_pairs(const std::vector<LoopResult>& loops, int robot);

// "All closures of pair 0-2 were rejected: 3, with squared residuals 120 450 1.2e+04 against barc^2 16.81; robot 0 has kept 5
// with robot 1"
std::string sentence(const RejectedPair& pair, double barc2);

}  // namespace covey::pgo
