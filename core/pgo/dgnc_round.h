// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One round of distributed graduated non-convexity (D-GNC), as one robot runs it: a data flow without clock.
//
// The round is a sequence of numbered messages. A robot sends its message n + 1 when, and only when, it holds message n of
// every other member; what it says depends on these messages and its own frozen graph alone. So all members are always
// within one message of each other, loss and delay can only delay, doubles and disorder do nothing, and the result is the
// same to the last bit as that of a lossless run. A robot that waits asks for what it misses (missing(), and the asked one
// answers from resend()); it is enough that everybody keeps the last two messages, and those after which the members
// fell into parts.
//
//   0 join       what I bring: segments, per member how many loops we share, with their hash, and a hash of my options;
//                whose options are not mine is waited for no longer, as it would end stages elsewhere
//   - keys       only if two members' hashes differ: the names of the shared loops; both keep those that both know
//   1 start      my public keyframes (ends of shared loops, and the first of each segment), in the frame of my start
//   2 alignment  of each pair of segments the lower one's robot averages the loops between them (paper, eq. 5);
//                then everybody grows the same spanning tree from the lowest robot, which puts all starts in one frame
//   3 part, 4 poses   where all start from odometry in the plane: a coarse pose graph of the team, and its solution by the anchor, to
//                which all bend their starts (coarse_graph.h, elected_exchange.h)
//   5 update 0   only the largest residual of my loops: all take mu_0 from the team's largest
//   6 ... updates of the poses, in stages of at most T between which weights and mu change; in the plane with binary weights also
//                steps along smooth motions (coarse_step.h)
//
// The opening is round_opening.h, the updates and their mathematics round_updates.h, the mail round_mail.h.
//
// With options.solver = kElected the opening ends after joins and keys, and one robot solves for all (elected_exchange.h).
//
// Members without loops between them, or with different options, fall into parts, each with its own anchor (its lowest
// robot) and frame W.
//
// Paper: Tian, Chang, Herrera Arias, Nieto-Granda, How, Carlone, "Kimera-Multi", T-RO 2022, section V.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/dgnc_options.h"
#include "core/pgo/round_message.h"
#include "core/pgo/round_result.h"

namespace covey::pgo {

class DgncRound {
 public:
  // mu > 0: the starts come from an unfinished round that had come to it; the round goes on from there if all starts of
  // the part do and have one frame.
  DgncRound(const RoundName& name, std::vector<int> members, GraphSnapshot graph,
            std::vector<SegmentStart> starts, double mu, const DgncOptions& options);
  ~DgncRound();
  DgncRound(DgncRound&&) noexcept;

  const RoundName& name() const;
  const std::vector<int>& members() const;

  // Null when taken, else why not: "sender", "number", "duplicate", "values".
  const char* receive(const RoundMessage& message);

  // Makes the next message if everything for it is there, which costs at most one update. False when it waits or is done.
  bool advance();
  std::vector<RoundMessage> take_outgoing();

  // Ends the round where it is, for observers that have seen enough (not part of the protocol).
  void stop();

  bool done() const;
  const RoundResult& result() const;  // when done

  int number() const;                // of the last message that was made
  std::vector<int> missing() const;  // members whose message number() is not here yet
  const RoundMessage* resend(
      int number) const;  // null when it is not made yet, or too old to be missing anywhere

  // For observers: updates so far, and the current poses of the placed segments, rounded to SE(3).
  int updates() const;
  double mu() const;
  std::int64_t frame() const;   // name of W, after the alignment
  std::uint64_t graph() const;  // hash of what is solved
  std::vector<SegmentResult> current() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace covey::pgo
