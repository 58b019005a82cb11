// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Plays recorded depth images with given poses (rgbd_folder.h) at their own pace times --speed, and ends with them.
//
// reads   nothing but RESEND, inside the bus
// writes  STATE, KEYFRAME (numbered) on --url, DEPTH (in bands) on --depth-url: all that a mesher needs
//
// STATUS: phases `playing`, `done`; gauge played_s; counters without_pose, dropped/DEPTH/unreadable

#include <filesystem>
#include <optional>

#include "procs/common/process.h"
#include "procs/player/given_odometry.h"
#include "procs/player/options.h"
#include "procs/player/rgbd_folder.h"

namespace covey {

class RgbdNode {
 public:
  RgbdNode(Process& process, const PlayerOptions& options);

 private:
  void publish_next();
  void load_next();
  void wait_for_next();
  void finish();
  void show_progress();

  Process& process_;
  Bus& depth_bus_;
  double speed_;
  SE3 T_O_D_;
  SE3 T_C_B_;
  RgbdFolder folder_;
  GivenOdometry odometry_;
  std::size_t next_ = 0;
  std::optional<depth_t> loaded_;  // the next image, decoded before it is due
  Utime start_ = 0;
  Utime not_before_ = 0;  // what was sent needs this long to be received
};

// The same as one LCM log, without waiting. Throws InputError.
void convert_rgbd(const PlayerOptions& options, const std::filesystem::path& config,
                  const std::filesystem::path& log);

}  // namespace covey
