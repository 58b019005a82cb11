// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What vio says, whatever it is made from: STATE, KEYFRAME, the --tum file.
//
// The --tum file has the pose at every frame as it was known when the frame had been worked on, never touched up later; for the frames that a segment
// started from, as known at its start. Each segment has an O of its own: where there were several, the poses of all are in the file, and a
// warning says so.
//
// A restarted vio opens a new segment, so it needs nothing of the one before. But the streams of its old segments would have nobody left who answers
// RESEND, and a reader that starts later would never hear of them: with --state KEYFRAMEs are kept (keyframe_log.h) and said again at the start.

#include <optional>

#include "core/geometry/trajectory.h"
#include "core/vio/output.h"
#include "procs/common/process.h"
#include "procs/vio/keyframe_log.h"

namespace covey {

class VioOutput {
 public:
  explicit VioOutput(Process& process);
  VioOutput(const VioOutput&) = delete;
  VioOutput& operator=(const VioOutput&) = delete;

  void publish_state(const vio::VioState& state);
  void publish_keyframe(const vio::VioKeyframe& keyframe);
  void add_to_trajectory(const vio::VioState& state);

 private:
  void write_trajectory() const;

  Process& process_;
  std::optional<KeyframeLog> log_;
  Trajectory trajectory_;
  std::int64_t segment_ = 0;  // of the last pose in it
  int segments_ = 0;
};

}  // namespace covey
