// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The updates of a round of D-GNC (dgnc_round.h), as one robot computes them on its part of an agreed problem: weights and
// poses, in the stages of gnc_stages.h. Every message but the first follows from those of the same number of all of the part.
//
// Updates. In the paper one robot updates at a time (RBCD); with N robots that all share loops this is N message delays per
// sweep. Here all update at once, and descent is kept by majorisation: of an edge between two robots, with P_i and P_j the
// two sides of its residual at the current point and C = (P_i + P_j) / 2,
//
//   |p_i - p_j|^2 <= 2 |p_i - C|^2 + 2 |p_j - C|^2      with equality at the current point,
//
// so each robot minimises its private edges plus its half of the right-hand side (block_solver.h), and the team's cost falls
// (Fan, Murphey, "Majorization Minimization Methods for Distributed Pose Graph Optimization", T-RO 2024). The current point
// is the combination of the last updates by Anderson's acceleration (anderson.h), in the metric of the blocks' Hessians: with
// f = -M^-1 g, the product of two steps is f_a^T M f_b = -f_a^T g_b. An update from a point of higher cost than that of the
// update before is taken back by all, and the combinations begun anew.
//
// Weights. Both ends of a shared loop know both poses as they were sent, so both compute the same weight (paper, eq. 14)
// and no message is spent on it; the lower robot owns the loop where loops are counted. They are computed where an update begins
// (gnc_stages.h says when), and what they add to the surrogate counts as cost, which falls with every weighing and every update while mu stays.
//
// Smooth motions. In the plane, where a stage with binary weights takes long, all go along what the nodes of coarse_step.h span after
// every fifth update, or after each where a round may take only few, in a message of its own; what that does not improve is taken
// back, and not tried again in that stage.
//
// Poses travel as steps from where the combination has the public keyframes, which all know (pose_steps.h), in units whose
// rounding costs the team a small part of what the update gains. One whose loops are all rejected travels only when it has moved so far that one of them
// might come back.

#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/anderson.h"
#include "core/pgo/block_solver.h"
#include "core/pgo/coarse_step.h"
#include "core/pgo/dgnc_options.h"
#include "core/pgo/gnc_stages.h"
#include "core/pgo/pose_steps.h"
#include "core/pgo/round_mail.h"
#include "core/pgo/round_result.h"

namespace covey::pgo {

class RoundUpdates {
 public:
  RoundUpdates(const AgreedProblem& problem, const DgncOptions& options);

  void send_first(RoundMail& mail) const;
  // Keeps what it has understood of the message, if it fits.
  bool fits(int robot, const RoundMessage& message);
  // With all messages of mail.number() there, and found to fit: sends the next one; false when the round is over instead.
  bool advance(RoundMail& mail);

  int updates() const { return updates_; }
  const std::vector<StageResult>& stage_results() const {
    return stage_results_;
  }  // of those that have ended
  const GncStages& stages() const { return stages_; }
  RoundSolution solution() const;

 private:
  // What is known of the members of the part, this robot included.
  struct Keyframes {         // a member's public ones
    std::vector<SE3> poses;  // as all know them
    StepCode code;
  };
  struct Member {
    Keyframes sent;
    std::optional<Keyframes> next;         // when the message that is there has been understood
    std::deque<std::vector<SE3>> results;  // poses after the last updates, newest first
    std::vector<SE3> ahead;                // their combination, where the update under way begins
    dpgo_advance_t said;                   // the last message
  };
  struct Step {       // of this robot's block, by one update
    Lifted moved;     // from the point that the update began at
    Lifted gradient;  // there
  };

  Eigen::VectorXd private_residuals(const Lifted& X) const;
  Eigen::VectorXd shared_residuals() const;
  TeamUpdate team_update() const;
  double largest_open_residual() const;
  double first_mu() const;
  void set_weights(const Lifted& X);
  void send_update(RoundMail& mail);
  bool wants_coarse_step() const;
  void ask_coarse_step(RoundMail& mail);
  void take_coarse_step(const RoundMail& mail);
  CoarseStep::Poses newest_public() const;
  Eigen::VectorXd edge_weights() const;
  void update(dpgo_advance_t& m);
  Lifted targets() const;
  void begin_anew();
  void accelerate(const TeamUpdate& team);
  void take_back();
  void note_stage(const TeamUpdate& team, std::int64_t bytes_sent);
  void remember(Step step, dpgo_advance_t& m);
  void encode_public_poses(dpgo_advance_t& m) const;
  std::vector<bool> poses_to_send(const std::vector<SE3>& wanted) const;
  PoseUnits units_for(double gain, const std::vector<SE3>& wanted, const std::vector<bool>& chosen) const;

  const AgreedProblem& problem_;
  DgncOptions options_;
  std::map<int, Member> members_;
  std::optional<CoarseStep> coarse_;
  enum class Coarse { kNone, kAsked, kTaken, kUseless } coarse_phase_ = Coarse::kNone;
  bool hessian_due_ = true;              // its weights are new
  std::unique_ptr<BlockSolver> solver_;  // its private edges: odometry, then the private loops
  int odometry_edges_ = 0;
  std::deque<Lifted> results_;  // own poses after the last updates, newest first
  std::deque<Step> steps_;      // of those that may be combined
  Eigen::VectorXd private_weights_;
  Eigen::VectorXd shared_weights_;
  GncStages stages_;
  Anderson anderson_;
  double cost_ = std::numeric_limits<double>::infinity();  // of the team, before the update before the last
  int undecided_ = 0;
  double penalty_ = 0.0;  // what the weights of own loops add to the surrogate
  int updates_ = 0;
  std::vector<StageResult> stage_results_;
};

}  // namespace covey::pgo
