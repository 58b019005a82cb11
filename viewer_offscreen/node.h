// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// viewer_offscreen on the buses of robots.
//
//   reads   TRAJECTORY, LOOP_WEIGHTS, on every bus of the command's Watch
//   writes  the pictures: live every so often, if a round was completed since; from a log once, at its end;
//           STATUS
//
// STATUS: gauges pictures (times they were replaced), robots (drawn). A picture that cannot be written is
// counted (failed/picture) and tried again.

#include "procs/common/process.h"
#include "viewer_offscreen/command.h"
#include "viewer_offscreen/team.h"

namespace covey::viewer {

class ViewerNode {
 public:
  // InputError where a bus or the pictures' folder is not there.
  ViewerNode(Process& process, const Command& command);

 private:
  void listen(Bus& bus);
  template <typename T>
  void listen(Bus& bus, const Channel<T>& channel);
  void draw_what_is_new();
  void draw();
  void draw_end_of_log();

  Process& process_;
  const Command& command_;
  Renderer renderer_;
  Team team_;
  int drawn_rounds_ = 0;
  int pictures_ = 0;
};

}  // namespace covey::viewer
