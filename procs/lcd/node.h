// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Loop closure detection of one robot, with its own past and with the other robots.
//
//   reads   KEYFRAME (stream); STEREO of the sensor bus, of which the pair of each keyframe's stamp is used; IN_LCD_*
//   writes  LOOP (stream); OUT_LCD_*; STATUS
//
// STATUS: phase `idle` (nothing to verify, nothing asked and not answered) or `working`; counters funnel/ROBOT/STEP
// (core/place/funnel.h); dropped/KEYFRAME/no_images; gauges keyframes (with features), others_keyframes, loops, untold (not
// acknowledged yet), waiting (candidates);
// extract_ms and work_ms of CPU.

#include <deque>
#include <optional>

#include "core/place/lcd_agent.h"
#include "core/place/stereo_features.h"
#include "procs/common/process.h"
#include "procs/lcd/image_buffer.h"
#include "procs/lcd/lcd_log.h"
#include "procs/lcd/options.h"

namespace covey {

class LcdNode {
 public:
  explicit LcdNode(Process& process);

 private:
  struct Expected {
    place::KeyframeName name;
    Utime utime;
    Utime until;  // when its images will not come any more
  };

  LcdNode(Process& process, const Rig& rig);
  LcdNode(Process& process, const LcdNodeOptions& options, const Rig& rig);
  template <typename T>
  void listen(const RadioChannel<T>& channel);
  void on_keyframe(const keyframe_t& message);
  void on_stereo(const stereo_t& message);
  void take_expected();
  void take_keyframe(const Expected& keyframe, const stereo_t& message);
  void work();
  void publish();
  void publish_status();

  Process& process_;
  place::StereoFeatures features_;
  place::LcdAgent agent_;
  std::optional<LcdLog> log_;
  ImageBuffer images_;
  std::deque<Expected> expected_;
  bool work_posted_ = false;
};

}  // namespace covey
