// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One robot's side of the distributed solver: who is there, when to begin a round, and what to do when somebody falls
// silent or comes back. A state machine without sockets and clock; the rounds themselves are in dgnc_round.h, what a robot
// holds of them in rounds.h.
//
//   agent.add(keyframe); agent.add(loop);          // from the robot's own front end
//   agent.receive(message, now);                   // from the other robots
//   agent.tick(now); agent.advance(now);           // often; advance does at most one update of the poses
//   for (const AgentMessage& message : agent.take_outgoing()) ...      // to everyone
//   if (auto result = agent.take_result()) ...
//
// Presence. Every robot says once a second, and when a round begins or ends, what it knows and where it stands, and whom it
// hears (presence.h); messages are passed on between robots that do not hear each other (relay.h). The lowest robot present
// that has keyframes is the anchor.
//
// Rounds. The anchor opens a round (dpgo_round_t, with a number above all it has heard of) when a present robot has
// something that the last round had not, or did not end that round, or was restarted, and nothing has changed for settle_us
// (or patience_us have passed). A robot joins when the number is new to it and it hears nobody lower than the sender. While
// a round runs, the anchor opens another one if a member falls silent or was restarted, or nothing moves for stall_us;
// the members take their unfinished poses, and mu, along as the start of the next.
//
// A robot that has ended a round waits for the others to end it, too, unless a member has left or was restarted, who may
// have taken with it what they miss: then it takes another round.
//
// A robot may be deaf for a while: while it solves alone, or because its computer stood still. The silence of others in that
// time does not count. While it solves, options.dgnc.meanwhile lets it say that it is there (say_presence).
//
// Starts are warm: a segment that has a solution starts from it, with newer keyframes chained on by odometry, so that
// robots which solved together keep their common frame and only the others are aligned.

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/pgo/agent_message.h"
#include "core/pgo/presence.h"
#include "core/pgo/relay.h"
#include "core/pgo/robot_graph.h"
#include "core/pgo/rounds.h"

namespace covey::pgo {

struct AgentOptions {
  DgncOptions dgnc;
  Utime beacon_us = kUsPerSecond;
  Utime silence_us = 5 * kUsPerSecond;    // without a sign of life: away
  Utime settle_us = 2 * kUsPerSecond;     // without change before a round is opened ...
  Utime patience_us = 10 * kUsPerSecond;  // ... unless there has been something new for that long
  Utime request_us = kUsPerSecond;        // without progress before missing messages are asked for
  Utime stall_us = 30 * kUsPerSecond;     // without progress before the anchor opens the round anew
};

// What a round cost this robot.
struct RoundAccount {
  Utime duration_us = 0;                     // from joining to the end
  std::map<std::string, std::size_t> bytes;  // said meanwhile, by type, each message once
  std::size_t total_bytes() const;
};

// Another robot that is known of, and not there or not in this robot's frame.
enum class Apart {
  kSilent,     // nothing is heard of it
  kNoClosure,  // it was in the last round, in another part: nothing connects the two
  kNotYet      // it was not in the last round
};
struct ApartRobot {
  int robot = 0;
  Apart why = Apart::kNotYet;
  bool has_my_frame = false;  // by the last round; only where it is silent since
  Utime silent_us = 0;        // for how long nothing has been heard
};

enum class AgentPhase { kIdle, kWaiting, kRound };  // nothing new; a round is due; in a round

class DgncAgent {
 public:
  // start_utime names this run of the process.
  DgncAgent(int robot, Utime start_utime, const AgentOptions& options);

  // Null when taken, else the reason (robot_graph.h).
  const char* add(const Keyframe& keyframe);
  const char* add(const Loop& loop);
  void restore(const Solution& solution);

  // Null when taken, else why not: "own", "unknown_sender", "not_anchor", "old_round", "not_member", "other_round", or a
  // reason of presence.h, relay.h or DgncRound::receive.
  const char* receive(const AgentMessage& message, Utime now);

  void tick(Utime now);
  bool advance(Utime now);       // true when it did something; call again
  void say_presence(Utime now);  // part of tick; for options.dgnc.meanwhile

  // From a log, what this robot said then: the run's name and the rounds it opened were decided by a clock that is gone. From
  // the first call on it opens no round by itself.
  void follow(const dpgo_beacon_t& own);
  void follow(const dpgo_round_t& own, Utime now);

  std::vector<AgentMessage> take_outgoing();
  std::optional<RoundResult> take_result();
  const RoundAccount& account() const { return account_; }  // of the last finished round

  AgentPhase phase() const;
  int robot() const { return robot_; }
  const Presence& presence() const { return presence_; }
  std::vector<ApartRobot> apart(Utime now) const;                  // ascending
  const GraphSnapshot& graph() const;                              // as of now
  const Solution& solution() const { return rounds_.solution(); }  // of the last finished round
  const DgncRound* round() const { return rounds_.joined(); }

 private:
  const char* receive_relay(const dpgo_relay_t& relay, Utime now);
  const char* receive_from(const AgentMessage& message, int speaker, int hops, Utime now);
  const char* take(const dpgo_beacon_t& beacon, Utime now);
  void pass_on(const AgentMessage& message, int speaker, int hops, Utime now);
  const char* receive_round(const dpgo_round_t& proposal, Utime now);
  const char* receive_request(const dpgo_request_t& request, Utime now);

  std::vector<int> present_robots(Utime now) const;  // with keyframes, this one included; ascending
  bool is_member(const dpgo_round_t& proposal) const;
  bool last_round_can_end(Utime now) const;
  bool something_new(Utime now) const;
  void follow_clock_back(Utime now);
  void excuse_silence(Utime now);
  void watch_for_changes(Utime now);
  void lead(Utime now);
  void open_round(Utime now);
  void say_round(Utime now);
  void join_round(const dpgo_round_t& proposal, Utime now);
  void say_beacon(Utime now);
  void say_neighbours(Utime now);
  void collect(Utime now);
  template <typename T>
  void say(T message, Utime now);

  int robot_;
  Utime start_utime_;
  AgentOptions options_;
  RobotGraph graph_;
  mutable std::optional<GraphSnapshot> snapshot_;
  Presence presence_;
  Relay relay_;
  bool following_ = false;  // a log of itself

  Rounds rounds_;
  RoundAccount account_;
  std::map<std::string, std::size_t> said_bytes_;  // since the round was joined

  std::map<int, std::pair<Utime, std::int64_t>> watched_;  // (run, graph) of each present robot
  Utime last_tick_ = 0;
  Utime last_change_ = 0;
  std::optional<Utime> new_since_;
  std::optional<Utime> last_beacon_;
  std::optional<Utime> last_neighbours_;
  Utime last_proposal_ = 0;
  std::vector<AgentMessage> outgoing_;
};

}  // namespace covey::pgo
