// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The rounds that one robot takes part in, one after the other (dgnc_round.h): the one that is joined now, the solution of
// the last one that has ended, and what one that was left before its end leaves to the next.
//
// A new round starts from where the last one was left: its poses, and its mu if nothing has come since; else from the last
// solution. Numbers only grow and are never given twice, for they name the frames that rounds leave.
//
// Repair. Who waits asks for what is missing every request_us; the asked one repeats it, also when it has ended the round.

#include <algorithm>
#include <covey/dpgo_request_t.hpp>
#include <covey/dpgo_round_t.hpp>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/pgo/dgnc_round.h"
#include "core/pgo/presence.h"
#include "core/pgo/robot_graph.h"
#include "core/pgo/solution.h"

namespace covey::pgo {

class Rounds {
 public:
  Rounds(int robot, const DgncOptions& options, Utime request_us)
      : robot_(robot), options_(options), request_us_(request_us) {}

  void restore(const Solution& solution);  // of an earlier run
  void hear_of(std::int64_t number) { newest_ = std::max(newest_, number); }
  std::int64_t newest() const { return newest_; }  // number of the newest round joined or heard of
  bool is_new(const dpgo_round_t& proposal) const;

  // A round of which this robot is a member; one that is running is left.
  void join(const dpgo_round_t& proposal, const GraphSnapshot& graph, Utime now);
  // Null when taken, else why not: "other_round", or a reason of DgncRound::receive.
  const char* receive(const RoundMessage& message, Utime now);
  bool advance(Utime now);  // true when it did something
  std::vector<RoundMessage> take_outgoing() { return round_->take_outgoing(); }
  std::optional<RoundResult> take_result() { return std::exchange(result_, std::nullopt); }

  // What is asked for and has not just been repeated; null: nothing. of_this_round: whether the request is.
  bool is_of_this_round(const dpgo_request_t& request) const;
  const RoundMessage* repeat(const dpgo_request_t& request, Utime now);
  // What this robot waits for, if it is time to ask.
  std::optional<dpgo_request_t> request(Utime now);

  const DgncRound* joined() const { return round_ ? &*round_ : nullptr; }  // running or ended
  bool running() const { return round_ && !round_->done(); }
  const dpgo_round_t& proposal() const { return proposal_; }    // of the round that is joined
  bool member_lost(const Presence& presence, Utime now) const;  // some member is away, or was restarted since
  // While it runs, of itself; once it has ended here, of the others in it.
  Utime last_progress() const { return last_progress_; }
  Utime joined_at() const { return joined_at_; }
  Utime ended_at() const { return ended_at_; }  // the last one that has ended

  const Solution& solution() const { return solution_; }  // of the last one that has ended
  const std::vector<int>& members() const {
    return members_;
  }  // of it, whether they ended in this robot's part or not

  void follow_clock_back(Utime now);
  void excuse(Utime deaf_us,
              Utime now);  // the robot has been deaf for so long: that was not the round's standing still

 private:
  void keep_unfinished();
  void keep_result(Utime now);

  int robot_;
  DgncOptions options_;
  Utime request_us_;
  std::optional<DgncRound> round_;  // kept after its end to answer requests
  dpgo_round_t proposal_{};
  std::int64_t newest_ = 0;
  Solution solution_;
  std::optional<Solution> unfinished_;
  std::optional<RoundResult> result_;
  std::vector<int> members_;
  int others_number_ = 0;  // the highest of the round's messages that came after its end here
  Utime joined_at_ = 0;
  Utime ended_at_ = 0;
  Utime last_progress_ = 0;
  Utime last_request_ = 0;
  std::map<int, Utime> last_repeat_;  // by number
};

}  // namespace covey::pgo
