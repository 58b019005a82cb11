// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Who has whose bags of words, and what is to be sent next: so that each bag crosses the air once, and robots that meet again go on
// where they stopped, after minutes apart or after a restart of either.
//
// Every robot says which bags it has of the robots in range (lcd_inventory_t): once a second, at once when somebody comes into range, and
// soon after bags came. That is all that is remembered of a conversation, and the receiver has it on disk: nobody sends what is listed.
//
// An owner sends what a robot in range lacks, the newest first; a bag that was never sent goes to everyone, one that a single robot lacks
// to that robot. At most `window` bags are on their way to a robot without being listed, so that no more is said into the void or into a
// slow link. How long a bag takes to be listed is measured for each robot, mean and deviation. One is lost when a later one was listed,
// and it itself should have been by the mean and four deviations (mail may be disordered); or when nothing new is listed for
// `patience_us`, which doubles. While nobody who wants them is in range, bags wait.
//
// Of two robots one looks for their common places (verifier_of); only that one wants the other's bags.

#include <covey/lcd_inventory_t.hpp>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "core/base/time.h"
#include "core/pgo/robot_graph.h"
#include "core/place/inventory.h"

namespace covey::place {

using pgo::KeyframeName;

// Of two robots, the one that looks for their common places.
inline int verifier_of(int a, int b) { return ((a + b) % 2 == 1) == (a < b) ? a : b; }

struct ExchangeOptions {
  Utime silent_us = 5 * kUsPerSecond;  // without a word: out of range
  Utime say_us = kUsPerSecond;
  Utime say_soon_us = 100'000;  // after a greeting, or after `soon_bags` or a hole
  int soon_bags = 8;
  int window = 64;                     // bags: 30 kB
  Utime first_late_us = kUsPerSecond;  // an overtaken bag, until it has been measured how long they take
  Utime least_late_us = 200'000;
  Utime patience_us = 2 * kUsPerSecond;
  Utime most_patience_us = 32 * kUsPerSecond;
};

class BagExchange {
 public:
  BagExchange(int robot, std::int64_t vocabulary, const ExchangeOptions& options = {})
      : robot_(robot), vocabulary_(vocabulary), options_(options) {}

  // An own bag that can be sent. In order: the last is the newest.
  void offer(const KeyframeName& own);
  // Another robot's bag is here, or was and is of no use. False: it was before, or there is no room to remember it.
  bool take(const KeyframeName& bag);

  // Anything came from a robot. True: it was not in range before.
  bool hear(int robot, Utime now);
  bool present(int robot, Utime now) const;

  // Null when taken, else why not: "values", "late" (overtaken by a newer one), "vocabulary" (it has another one), or as decode_ids says.
  const char* receive(const lcd_inventory_t& message, Utime now);

  struct Due {
    KeyframeName name;
    int to = -1;
  };
  // The bag that is to be sent now, if any.
  std::optional<Due> next(Utime now);
  // What is to be said now of the bags that are here, if anything.
  std::optional<lcd_inventory_t> say(Utime now);

  // A robot in range lacks a bag, and has not been asked in vain for long.
  bool owes(Utime now) const;

 private:
  struct Flight {
    std::int64_t order = 0;  // of sending, to this robot
    Utime sent = 0;
  };
  struct Peer {
    Utime heard = 0;
    std::optional<Utime> said;     // of its newest inventory, in its clock
    std::set<int> missing;         // numbers of own bags, neither listed nor on their way
    std::map<int, Flight> flying;  // on their way, not listed yet
    std::int64_t next_order = 0;
    std::int64_t listed_order = -1;  // the newest that was listed
    Utime progress = 0;              // when one was listed last
    std::optional<Utime> taken;      // from sending to being listed, smoothed
    Utime deviation = 0;
    Utime patience = 0;
  };

  bool wants(int robot, const Peer& peer) const { return peer.said && verifier_of(robot_, robot) == robot; }
  void compare(Peer& peer, const std::map<Utime, RunInventory>& runs, bool whole, Utime now);
  void give_up_lost(Peer& peer, Utime now);
  Utime late_after(const Peer& peer) const;
  Inventory inventory(Utime now);

  int robot_;
  std::int64_t vocabulary_;
  ExchangeOptions options_;
  std::vector<KeyframeName> own_;
  std::vector<bool> sent_;
  std::map<int, std::map<Utime, IdRanges>> held_;
  std::map<int, Peer> peers_;
  std::optional<Utime> said_;
  int new_bags_ = 0;  // since then
  bool soon_ = false;
  int turn_ = 0;  // the robot to be listed first
};

}  // namespace covey::place
