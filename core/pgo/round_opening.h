// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The opening of a round: from what each member brings to a problem that all have agreed on (agreed_problem.h). Messages,
// numbered from 0 (dgnc_round.h has the whole round):
//
//   join       what I bring: segments, per member how many loops we share, with their hash, and a hash of my options;
//              whose options are not mine is waited for no longer, as it would decide otherwise
//   keys       only if two members' hashes differ: the names of the shared loops; both keep those that both know
//   start      my public keyframes (ends of shared loops, and the first of each segment), in the frame of my start
//   alignment  of each pair of segments the lower one's robot averages the loops between them (paper, eq. 5), and
//              says what else they may mean where that is in doubt; then everybody grows the same spanning tree
//              from the lowest robot (frame_tree.h), which puts all starts in one frame
//
// Members that no loops connect fall into parts, each with its own anchor (its lowest robot) and frame.

#include <cstdint>
#include <optional>
#include <set>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/central.h"
#include "core/pgo/frame_alignment.h"
#include "core/pgo/round_mail.h"

namespace covey::pgo {

struct OpeningOptions {
  std::uint64_t hash = 0;  // of all by which members must decide alike
  AlignmentOptions alignment;
  bool align = true;  // false: it is over after joins and keys, without starts, frames and ends
  // By which segments that come from odometry alone are first solved by their own loops (local_start.h); nothing: they start
  // as odometry has them.
  std::optional<RobustOptions> local;
};

struct TiedFrames {  // as all members know them
  StartFrame a;
  StartFrame b;
  int loops = 0;
};

class RoundOpening {
 public:
  // mu > 0: where an unfinished round left the starts. Sends the join.
  RoundOpening(RoundMail& mail, GraphSnapshot graph, std::vector<SegmentStart> starts, double mu,
               const OpeningOptions& options);

  // Whether this can be the message of `robot` that is due.
  bool fits(int robot, const RoundMessage& message) const;
  // With all messages of mail.number() there: sends the next one, or is done, and it is the next sender's turn.
  void advance(RoundMail& mail);

  bool done() const { return phase_ == Phase::kDone; }
  AgreedProblem& problem() { return problem_; }

 private:
  enum class Phase { kJoin, kKeys, kStart, kAlignment, kDone };

  void send_join(RoundMail& mail, double mu);
  void take_joins(RoundMail& mail);
  void part_by_options(RoundMail& mail);
  void send_keys(RoundMail& mail);
  void take_keys(RoundMail& mail);
  template <typename Agreed>
  void agree(RoundMail& mail, Agreed agreed);
  std::int64_t told_hash(int robot, int peer) const;

  void send_start(RoundMail& mail);
  void take_starts(RoundMail& mail);
  void resolve_loops();
  void send_alignment(RoundMail& mail);
  void take_alignments(RoundMail& mail);
  void keep_lone_loops(const std::vector<TiedFrames>& tied);

  OpeningOptions options_;
  Phase phase_ = Phase::kJoin;
  AgreedProblem problem_;
};

}  // namespace covey::pgo
