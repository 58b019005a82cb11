// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/pgo/block_solver.h"
#include "core/pgo/frame_alignment.h"
#include "core/pgo/hash.h"

namespace covey::pgo {

struct DgncOptions {
  int rank = 5;  // of the lifted poses

  // Truncation of a loop's squared residual; the 0.99 quantile of chi-square with 6 degrees of freedom.
  double barc2 = 16.812;
  bool robust = true;  // false: plain least squares, one stage of at most max_updates

  double mu_step = 2.0;     // factor between stages; the paper's is 1.4 (DECISIONS.md has both measured)
  double mu_max = 30.0;     // beyond, weights are made binary
  int updates = 15;         // per stage, at most (T of the paper)
  int final_updates = 100;  // per stage with binary weights, at most
  int final_stages = 3;     // at most: the last ones only follow loops that changed sides
  int max_updates = 2000;   // without robustness

  // A stage ends early when an update lowers the team's cost by less than this part of it.
  double tolerance = 1e-4;
  double final_tolerance = 1e-6;  // the same with binary weights
  bool momentum = true;           // Nesterov's, restarted when it overshoots

  AlignmentOptions alignment{.min_inliers = 1};
  BlockSolverOptions block{.max_outer = 1, .max_inner = 10};  // more per update costs time and gains nothing
};

// Of those by which all members of a round must decide alike. Not of `alignment` and `block`: what one member makes by
// these the others take as it comes.
inline std::uint64_t common_hash(const DgncOptions& options) {
  Hash hash;
  for (const double value :
       {options.barc2, options.mu_step, options.mu_max, options.tolerance, options.final_tolerance}) {
    hash.add(value);
  }
  for (const int value : {options.rank, options.updates, options.final_updates, options.final_stages,
                          options.max_updates, int{options.robust}, int{options.momentum}}) {
    hash.add(static_cast<std::uint64_t>(value));
  }
  return hash.value();
}

}  // namespace covey::pgo
