// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The sending side of what must arrive: messages are numbered, cut into fragments, and each fragment is
// repeated until every robot that it is meant for has acknowledged it. A message to everyone is sent once;
// then a fragment that one robot misses is repeated to that robot, and one that several miss is repeated to
// everyone.
//
// When to repeat. A round trip is measured per robot from the acks (smoothed mean plus four deviations, RFC
// 6298). After a robot's last progress the waits between repeats grow by half each time, from that round trip
// to longest_wait_us. A robot that has been silent is not sent anything again until it is heard. One that
// stays silent for gone_after_us, or talks but has never acknowledged anything, is given up, which is
// counted. At most kFragmentWindow fragments are sent beyond the first one that a robot misses.
//
// To whom. A message to everyone is meant for the robots that were heard in the last gone_after_us, and for
// those that turn up within linger_us: a team that starts together misses nothing.
//
// Numbers in acks come from outside: an ack can only say what exists, and at worst a lie stops the repeats to
// the liar.

#include <array>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/base/time.h"
#include "core/radio/treatment.h"
#include "core/radio/wire.h"

namespace covey::radio {

struct ReliableOptions {
  Utime linger_us = 2 * kUsPerSecond;
  Utime silent_after_us = 5 * kUsPerSecond;
  Utime gone_after_us = 60 * kUsPerSecond;
  Utime first_wait_us = 300'000;  // until a round trip has been measured
  Utime shortest_wait_us = 40'000;
  Utime longest_wait_us = 4 * kUsPerSecond;
  std::size_t max_bytes = 16 * 1024 * 1024;  // of unfinished messages
};

class ReliableSender {
 public:
  ReliableSender(int robot, Utime epoch, ReliableOptions options)
      : robot_(robot), epoch_(epoch), options_(options) {}

  // Null, or why it was not taken: "message_too_long", "queue_full".
  const char* submit(Module module, int priority, int to, Bytes body, Utime now);

  // The next fragment of this module that is due, highest priority and oldest message first.
  std::optional<radio_fragment_t> next(Module module, Utime now);

  // Refusals: "ack_stale" (of another run of ours), "ack_numbers".
  const char* on_ack(const radio_ack_t& ack, Utime now);

  // Anything at all was heard from a robot.
  void on_heard(int robot, Utime now);
  // The robot runs anew: it has none of what it had not finished.
  void on_restart(int robot, Utime now);

  // Gives up on robots that are long gone; says how many messages they missed.
  int on_tick(Utime now);

  std::size_t open_messages() const { return open_.size(); }
  std::size_t open_bytes() const { return open_bytes_; }
  std::int64_t repeats() const { return repeats_; }

 private:
  struct Peer {
    Utime last_heard = 0;
    bool acknowledges = false;        // has ever acknowledged anything: it hears us, and is not an invention
    Utime progress = 0;               // its last ack that said something new
    std::optional<Utime> round_trip;  // smoothed
    Utime deviation = 0;
  };
  struct Target {
    std::vector<bool> have;
    std::int32_t below = 0;
    std::int64_t most = 0;  // fragments that it ever had at once
    Utime progress = 0;     // when it last came forward, or began
    std::int64_t ack_number = -1;
  };
  struct Message {
    Module module = Module::kControl;
    int priority = 0;
    int to = 0;
    Bytes body;
    std::int32_t fragments = 0;
    std::int32_t unsent = 0;  // fragments unsent ... were never sent
    Utime submitted = 0;
    std::vector<Utime> last_sent;
    std::map<int, Target> targets;  // robots that miss some of it
    std::set<int> finished;
  };
  using Messages = std::map<std::int64_t, Message>;
  struct Choice {
    std::int32_t fragment = -1;  // -1: none is due ...
    int to = 0;
    Utime due = 0;  // ... before this
  };

  Target new_target(const Message& message, Utime now) const;
  Utime round_trip_bound(const Peer& peer) const;
  bool silent(int robot, Utime now) const;
  Choice choose(const Message& message, Utime now) const;
  bool finished(const Message& message, Utime now) const;
  void measure(Peer& peer, Utime round_trip);
  void wake(Messages::iterator message);
  void sleep(Messages::iterator message, Utime due);
  void close(Messages::iterator message);
  std::int64_t oldest() const { return open_.empty() ? next_number_ : open_.begin()->first; }

  int robot_;
  Utime epoch_;
  ReliableOptions options_;
  std::int64_t next_number_ = 0;
  Messages open_;
  std::size_t open_bytes_ = 0;
  std::int64_t repeats_ = 0;
  std::map<int, Peer> peers_;
  // Every open message is in exactly one of these: due now, by (-priority, number), or later.
  std::array<std::set<std::pair<int, std::int64_t>>, kModules> ready_;
  std::set<std::pair<Utime, std::int64_t>> asleep_;
  std::map<std::int64_t, Utime> asleep_until_;
};

}  // namespace covey::radio
