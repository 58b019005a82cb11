// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/loops.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace covey {
namespace {

void count(PairScore& score, const JudgedClosure& closure) {
  const bool right = closure.right.value_or(false);
  ++score.total;
  score.kept += closure.kept ? 1 : 0;
  score.right += right ? 1 : 0;
  score.kept_right += closure.kept && right ? 1 : 0;
  score.truth_known = score.truth_known && closure.right.has_value();
}

}  // namespace

bool is_right_closure(const SE3& T_A_B_measured, const SE3& T_A_B_true, const ClosureLimits& limits) {
  const SE3 error = T_A_B_true.inverse() * T_A_B_measured;
  const double rotation_deg = error.rotation.log().norm() * 180.0 / M_PI;
  return error.translation.norm() <= limits.translation_m && rotation_deg <= limits.rotation_deg;
}

LoopScore score_loops(const std::vector<JudgedClosure>& closures, int robots) {
  LoopScore score;
  std::vector<std::vector<std::size_t>> place(robots, std::vector<std::size_t>(robots));
  for (int a = 0; a < robots; ++a) {
    for (int b = a; b < robots; ++b) {
      place[a][b] = score.pairs.size();
      PairScore pair;
      pair.a = a;
      pair.b = b;
      score.pairs.push_back(pair);
    }
  }
  for (const JudgedClosure& closure : closures) {
    const auto [a, b] = std::minmax(closure.robot_a, closure.robot_b);
    COVEY_CHECK(a >= 0 && b < robots);
    count(score.pairs[place[a][b]], closure);
    count(score.sum, closure);
  }
  if (score.sum.truth_known && score.sum.kept > 0) {
    score.precision = static_cast<double>(score.sum.kept_right) / score.sum.kept;
  }
  if (score.sum.truth_known && score.sum.right > 0) {
    score.recall = static_cast<double>(score.sum.kept_right) / score.sum.right;
  }
  return score;
}

}  // namespace covey
