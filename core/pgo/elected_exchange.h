// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the members of a round do after its joins and keys when one of them solves for all (elected.h): the lowest.
//
//   n      part    my part of the graph, to the elected; the elected's is empty
//   n + 1  poses   the elected's result, to all; the others' are empty
//
// As in every round a message follows from those of the same number of all members, so that loss and delay only delay.

#include <optional>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/elected.h"
#include "core/pgo/round_mail.h"
#include "core/pgo/round_result.h"

namespace covey::pgo {

class ElectedExchange {
 public:
  // Of the problem: the part, the members' joins, the own graph and its warnings. for_all: everybody gets everybody's poses.
  ElectedExchange(const AgreedProblem& problem, const ElectedOptions& options, bool for_all = false);

  void send_first(RoundMail& mail) const;
  bool fits(int robot, const RoundMessage& message) const;
  // With all messages of mail.number() there: sends the next one; false when the round is over instead.
  bool advance(RoundMail& mail);

  int iterations() const { return iterations_; }        // of the solver; of the elected alone
  const dpgo_poses_t& poses() const { return poses_; }  // when it is over
  RoundResult result() const;                           // when it is over; all but bytes

 private:
  int elected() const { return problem_.part.front(); }
  bool am_elected() const { return problem_.robot() == elected(); }

  const AgreedProblem& problem_;
  ElectedOptions options_;
  bool for_all_;
  SegmentNames names_;
  bool parts_are_there_ = false;
  int iterations_ = 0;
  dpgo_poses_t poses_;  // as this robot has them
};

}  // namespace covey::pgo
