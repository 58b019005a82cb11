// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Passing messages on between robots that do not hear each other.
//
// A robot takes a message of X out of the air from S: from X itself, or from a robot that passes it on. It passes it on, once,
// if it has a neighbour Z (each hears the other, dpgo_neighbours_t) that hears neither X nor S; but not where a lower robot is
// there to do that, one that hears S and has Z for a neighbour. So nothing is passed on where all hear all, a part of the team
// needs one robot for each hop, and two robots between the same parts do not say everything twice. (To choose as few relays as
// reach everybody is the idea of the multipoint relays of OLSR, RFC 3626; here the lowest number decides.)
//
// Without loss a message reaches everybody whom some chain of links joins with X. Suppose that it does not reach Z, and let P
// be the lowest of the neighbours of Z that have it, from S. Z does not hear S, since S has sent it. So P passed it on, or a
// lower robot hears S, therefore has it, and is a neighbour of Z, which P is the lowest of.
//
// Repair goes hop by hop. Who is asked for a round's message by a robot for which it has passed that message on says it
// again; only what it has not itself is asked for further off.

#include <covey/dpgo_relay_t.hpp>
#include <covey/dpgo_request_t.hpp>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/pgo/agent_message.h"
#include "core/pgo/presence.h"

namespace covey::pgo {

// What was passed on, taken out: one of the two is set.
struct Unwrapped {
  const char* refused =
      nullptr;  // "values", "undecodable", "origin_mismatch" (it is another robot's message)
  std::optional<AgentMessage> message;
};
Unwrapped unwrap(const dpgo_relay_t& relay);
// What must arrive; the rest is said again anyway.
bool is_of_a_round(const dpgo_relay_t& relay);

class Relay {
 public:
  explicit Relay(int robot) : robot_(robot) {}

  // The message to pass on, if it is to be. `speaker`: from whom it was heard; hops: how often it had been passed on.
  std::optional<dpgo_relay_t> pass_on(const AgentMessage& message, int speaker, int hops,
                                      const Presence& presence, Utime now);

  // What a neighbour asks for and this robot has passed on to it, to be said again; not before `pause_us` have passed since.
  struct Repeated {
    std::vector<dpgo_relay_t> relays;
    bool complete = true;  // nothing is left for others to answer
  };
  Repeated repeat(const dpgo_request_t& request, const Presence& presence, Utime pause_us, Utime now);

 private:
  struct Kept {
    RoundName round;
    int number;
    Utime said;
    dpgo_relay_t relay;
  };

  bool needed(int origin, int speaker, const Presence& presence, Utime now) const;
  bool lower_passes_on(int origin, int speaker, int to, const Presence& presence, Utime now) const;
  bool first_time(const Bytes& message);
  void keep(const AgentMessage& message, const dpgo_relay_t& relay, Utime now);
  Kept* find(int origin, const dpgo_request_t& request);

  int robot_;
  std::set<std::uint64_t> passed_;        // hashes of the last messages ...
  std::deque<std::uint64_t> order_;       // ... and these in the order of passing
  std::map<int, std::deque<Kept>> kept_;  // of rounds, the last ones of each origin
};

}  // namespace covey::pgo
