// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How well loop closures were told apart: for each pair of robots (and each robot with itself) how many there
// were, how many were kept, and, where ground truth is known, how many of those are right. A closure is right
// when it measures what truth says of its two poses, within limits that are wide against its noise and narrow
// against a wrong match.

#include <optional>
#include <vector>

#include "core/geometry/se3.h"

namespace covey {

struct ClosureLimits {
  double translation_m = 1.0;
  double rotation_deg = 10.0;
};

bool is_right_closure(const SE3& T_A_B_measured, const SE3& T_A_B_true, const ClosureLimits& limits = {});

struct JudgedClosure {
  int robot_a = 0;
  int robot_b = 0;
  bool kept = false;
  std::optional<bool> right;  // nothing where truth is not known
};

struct PairScore {
  int a = 0;
  int b = 0;  // a <= b
  int total = 0;
  int kept = 0;
  int right = 0;       // of all
  int kept_right = 0;  // of the kept ones
  bool truth_known = true;
};

struct LoopScore {
  std::vector<PairScore> pairs;  // every a <= b, in order
  PairScore sum;
  std::optional<double> precision;  // kept and right / kept; nothing without truth or where nothing was kept
  std::optional<double> recall;     // kept and right / right
};

LoopScore score_loops(const std::vector<JudgedClosure>& closures, int robots);

}  // namespace covey
