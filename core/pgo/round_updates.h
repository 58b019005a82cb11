// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The updates of a round of D-GNC (dgnc_round.h), as one robot computes them on its part of an agreed problem: weights and
// poses, in the stages of gnc_stages.h. Every message but the first follows from those of the same number of all of the part.

#include <map>
#include <memory>
#include <vector>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/block_solver.h"
#include "core/pgo/dgnc_options.h"
#include "core/pgo/gnc_stages.h"
#include "core/pgo/momentum.h"
#include "core/pgo/round_mail.h"
#include "core/pgo/round_result.h"

namespace covey::pgo {

class RoundUpdates {
 public:
  RoundUpdates(const AgreedProblem& problem, const DgncOptions& options);

  void send_first(RoundMail& mail) const;
  bool fits(int robot, const RoundMessage& message) const;
  // With all messages of mail.number() there: sends the next one; false when the round is over instead.
  bool advance(RoundMail& mail);

  int updates() const { return updates_; }
  double gradient() const { return gradient_; }  // its norm, of this robot's block before the last update
  const GncStages& stages() const { return stages_; }
  RoundSolution solution() const;

 private:
  // What is known of a member of the part, this robot included.
  struct Member {
    Lifted now;     // public keyframes as sent, r x 4m
    Lifted before;  // one update earlier
    double cost = 0.0;
    double decrease = 0.0;
    double overshoot = 0.0;
    double max_r2 = 0.0;
    int undecided = 0;
  };

  Eigen::VectorXd private_residuals() const;
  Eigen::VectorXd shared_residuals() const;
  TeamUpdate team_update() const;
  double first_mu() const;
  void set_weights();
  void update(dpgo_update_t& m);
  void encode_public_poses(dpgo_update_t& m) const;

  const AgreedProblem& problem_;
  DgncOptions options_;
  std::map<int, Member> members_;
  std::unique_ptr<BlockSolver> solver_;  // its private edges: odometry, then the private loops
  int odometry_edges_ = 0;
  Lifted X_;
  Lifted X_before_;
  Eigen::VectorXd private_weights_;
  Eigen::VectorXd shared_weights_;
  GncStages stages_;
  Momentum momentum_;
  int undecided_ = 0;
  int updates_ = 0;
  double gradient_ = 0.0;
};

}  // namespace covey::pgo
