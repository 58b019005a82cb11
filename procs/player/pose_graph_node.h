// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Plays one robot's pose graph as its front end would have said it (core/sim/front_end.h).
//
// reads   nothing but RESEND, inside the bus
// writes  KEYFRAME, LOOP (numbered streams), then STREAM_HEAD until it is told to stop: phases "playing",
// "done"
//
// Started again it says the same from the beginning; readers know the numbers and drop them as duplicates. With --state
// it knows when it was first started: what was due by now is said at once, paced for stock receive buffers, and the
// rest in time, so that a restart costs the run nothing.

#include <vector>

#include "core/sim/front_end.h"
#include "procs/common/process.h"
#include "procs/player/options.h"

namespace covey {

class PoseGraphNode {
 public:
  PoseGraphNode(Process& process, const PlayerOptions& options);

 private:
  void publish_due();
  void publish_next();
  bool is_due() const;
  double recorded_s(std::size_t message) const;  // since the first message

  Process& process_;
  double speed_;
  std::vector<sim::FrontEndMessage> messages_;
  std::size_t next_ = 0;
  Utime start_ = 0;
  EventLoop::TimerId timer_ = 0;
};

}  // namespace covey
