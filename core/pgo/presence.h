// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Who of the team is there, and who hears whom.
//
// Every robot says once a second where it stands (dpgo_beacon_t) and whom it hears directly (dpgo_neighbours_t). It is
// present while anything of it arrives, on whatever way (relay.h), and away after silence_us without; it is a neighbour
// while it is heard directly, given up after half of that, so that others pass its messages on before it counts as away.

#include <covey/dpgo_beacon_t.hpp>
#include <covey/dpgo_neighbours_t.hpp>
#include <map>
#include <vector>

#include "core/base/time.h"

namespace covey::pgo {

struct Peer {
  dpgo_beacon_t beacon;
  Utime beacon_heard = 0;
  Utime heard = 0;            // anything
  Utime heard_directly = -1;  // the same, without another one's help; -1: never
  dpgo_neighbours_t neighbours;
  Utime neighbours_heard = -1;  // -1: never
};

class Presence {
 public:
  Presence(int robot, Utime silence_us) : robot_(robot), silence_us_(silence_us) {}

  // Null when taken, else why not: "values", "late" (overtaken by a newer one), "unknown_sender" (no beacon before).
  const char* take(const dpgo_beacon_t& beacon, Utime now);
  const char* take(const dpgo_neighbours_t& neighbours, Utime now);
  // Something of a known robot arrived.
  void hear(int robot, bool directly, Utime now);
  // The clock was set back: what was noted in its future would last until then.
  void follow_clock_back(Utime now);
  // For so long until now this robot has not listened: that was nobody's silence.
  void excuse(Utime deaf_us, Utime now);

  bool knows(int robot) const { return peers_.count(robot) > 0; }
  const Peer& peer(int robot) const { return peers_.at(robot); }
  const std::map<int, Peer>& peers() const { return peers_; }

  bool present(int robot, Utime now) const;
  bool neighbour(int robot, Utime now) const;
  std::vector<int> neighbours(Utime now) const;  // ascending

  // Whether `listener` has said lately that it hears `speaker` directly.
  bool hears(int listener, int speaker, Utime now) const;

 private:
  int robot_;
  Utime silence_us_;
  std::map<int, Peer> peers_;  // of at most radio::kMaxRobots
};

}  // namespace covey::pgo
