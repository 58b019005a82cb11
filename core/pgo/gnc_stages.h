// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The stages of graduated non-convexity in a round: each minimises the surrogate of one mu of the schedule in core/graph/gnc.h,
// until weights are binary and none changes sides any more (Kimera-Multi, T-RO 2022, eq. 14). Before mu says that decisions are
// made, it rises sevenfold with every update of the first stage: all loops pull there, and the longer they do, the more the wrong
// ones bend a good start. From then on loops are weighed anew before each update, with binary weights once a stage. All members
// go by the sums of what all have said, so all end the same stage after the same update.

#include <cstdint>

#include "core/pgo/dgnc_options.h"

namespace covey::pgo {

struct TeamUpdate {            // sums over the members
  double cost = 0.0;           // before their last update, with what the weights add
  double decrease = 0.0;       // by it
  std::int64_t undecided = 0;  // loops
  double gradient_sq = 0.0;    // of the gradient's norm, before that update
  double penalty = 0.0;        // of the cost: what the weights add
};

class GncStages {
 public:
  explicit GncStages(const DgncOptions& options) : options_(options) {}

  bool ended(const TeamUpdate& team) const;
  // The next one; the first begins at first_mu, infinite for binary weights. False when there is none.
  bool begin(const TeamUpdate& team, double first_mu);
  void count_update();
  // With the last update that was counted: costs before and after are of different surrogates.
  bool mu_rose() const { return rose_; }

  bool weighs() const;             // before the update that comes
  double weight(double r2) const;  // in [0, 1]
  double penalty(
      double weight) const;  // what it adds to the surrogate; 0 in the last stages, where it is constant
  double rejection() const;  // the smallest r2 of weight 0
  // Whether a loop keeps the round going: it is between the sides, or, with binary weights, has just changed sides.
  bool undecided(double weight, double weight_before) const;

  double mu() const { return mu_; }
  bool binary() const { return final_; }
  int stages() const { return stages_; }
  int stage_updates() const { return stage_updates_; }

 private:
  double next_mu() const;
  bool mu_rises() const;
  bool used_up() const;
  bool has_to_decide() const;
  bool settled(const TeamUpdate& team) const { return final_stages_ > 1 && team.undecided == 0; }
  bool converged(const TeamUpdate& team) const;

  DgncOptions options_;
  double mu_ = 0.0;
  bool rose_ = false;
  bool begun_ = false;
  bool final_ = false;  // binary weights
  int final_stages_ = 0;
  int stages_ = 0;
  int stage_updates_ = 0;
  int updates_ = 0;
};

}  // namespace covey::pgo
