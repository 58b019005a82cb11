// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

#include "core/pgo/block_solver.h"
#include "core/pgo/edge_noise.h"
#include "core/pgo/frame_alignment.h"
#include "core/pgo/hash.h"

namespace covey::pgo {

enum class RoundSolver {
  kDgnc,     // all of the part, together (round_updates.h)
  kElected,  // the lowest robot, for all (elected_exchange.h)
};

struct DgncOptions {
  RoundSolver solver = RoundSolver::kDgnc;
  // Of edges with covariances. full_covariances: `elected` decides and solves with all of them, not with kappa and tau.
  NoiseOptions noise{};
  bool full_covariances = false;
  int dimension = 3;  // 2: the poses are in the plane; `elected` takes advantage of it

  // Truncation of a loop's squared residual; the 0.99 quantile of chi-square with 6 degrees of freedom.
  double barc2 = 16.812;
  bool robust = true;  // false: plain least squares, one stage of at most max_updates

  int rounds = 8;           // stages until weights are binary, with mu_step 0
  double mu_step = 0.0;     // factor of mu between stages; 0: as it takes for `rounds`. The paper's is 1.4
  double mu_max = 30.0;     // beyond, weights are made binary
  int updates = 60;         // per stage, at most (T of the paper, 15 there)
  int final_updates = 100;  // per stage with binary weights, at most
  int final_stages = 4;     // at most: the last ones only follow loops that changed sides
  int max_updates = 2000;   // without robustness
  int coarse_after =
      30;  // of these, until a planar team takes steps along smooth motions, too (coarse_step.h)
  // The round ends where it is after so many, the last fifth with binary weights and steps along smooth motions after every
  // one; 0: no limit. The paper's early stop: 50
  int total_updates = 0;

  // A stage ends early when an update lowers the team's cost by less than this part of it, without what the weights add,
  double tolerance = 5e-6;
  double undecided_tolerance = 1e-6;  // or than this part of barc2 for each loop that is undecided.
  double final_tolerance =
      1e-9;  // with binary weights and no loop that has changed sides, and without robustness: part of the cost
  int look_back = 8;  // updates that Anderson's acceleration combines the newest with

  AlignmentOptions alignment{.min_inliers = 1};
  bool local_start = true;  // segments that come from odometry alone are first solved by their own loops
  double rounding =
      0.001;  // of the poses that are sent: what it may cost, as a part of what an update gains; a tenth in the end
  // Called again and again while this robot solves something by itself: starts, or what it was elected for.
  std::function<void()> meanwhile = {};
  BlockSolverOptions block{.max_outer = 1, .max_inner = 20};  // more per update costs time and gains nothing
};

// Of those by which all members of a round must decide alike. Not of the last ones: what one member makes by
// these the others take as it comes.
inline std::uint64_t common_hash(const DgncOptions& options) {
  Hash hash;
  const NoiseOptions& noise = options.noise;
  for (const double value : {noise.floor_translation_sigma, noise.floor_rotation_sigma,
                             noise.isotropic_translation_sigma, noise.isotropic_rotation_sigma}) {
    hash.add(value);
  }
  for (const double value : {options.barc2, options.mu_step, options.mu_max, options.tolerance,
                             options.undecided_tolerance, options.final_tolerance}) {
    hash.add(value);
  }
  for (const int value : {static_cast<int>(options.solver), int{noise.isotropic}, int{noise.floored_odometry},
                          int{options.full_covariances}, options.dimension}) {
    hash.add(static_cast<std::uint64_t>(value));
  }
  for (const int value :
       {options.rounds, options.updates, options.final_updates, options.final_stages, options.max_updates,
        options.total_updates, int{options.robust}, options.look_back, options.coarse_after}) {
    hash.add(static_cast<std::uint64_t>(value));
  }
  return hash.value();
}

}  // namespace covey::pgo
