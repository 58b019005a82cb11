// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a team's robots last said of where they were (TRAJECTORY) and of their loop closures (LOOP_WEIGHTS),
// as a figure. A round comes in parts; it counts once all are there, and the newest such round of each robot
// wins.

#include <covey/loop_weights_t.hpp>
#include <covey/trajectory_t.hpp>
#include <map>
#include <vector>

#include "core/base/time.h"
#include "viewer_offscreen/figure.h"

namespace covey::viewer {

// One robot's rounds, of either message.
template <typename Message>
class Rounds {
 public:
  // Null, or why the part is of no use.
  const char* take(const Message& part);
  // The parts of the newest whole round, in order; empty before there is one.
  const std::vector<Message>& newest() const { return newest_; }
  int completed() const { return completed_; }  // rounds so far

 private:
  Utime utime_ = 0;  // of the round in parts_ or, where it is whole, in newest_
  std::map<int, Message> parts_;
  std::vector<Message> newest_;
  int completed_ = 0;
};

class Team {
 public:
  // Null, or why the part is of no use: "values", "old" or "duplicate".
  const char* take(const trajectory_t& part);
  const char* take(const loop_weights_t& part);

  int rounds() const;  // completed so far, of all robots and both messages
  int robots() const;  // that have poses to be drawn

  // Curves in the robots' own palette colours, and the loops between poses that are known: accepted where the
  // weight is above one half. Of a loop between two robots, the one with the lower id is believed. A robot
  // whose W is not the first one's is named with its anchor, and no loop joins the two.
  void add_to(FigureContent& content) const;

 private:
  std::map<int, Rounds<trajectory_t>> trajectories_;
  std::map<int, Rounds<loop_weights_t>> loops_;
};

}  // namespace covey::viewer
