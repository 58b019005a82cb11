// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Plays a recording in EuRoC's layout (asl_folder.h) at its own pace times --speed, and ends with it.
//
// reads   nothing
// writes  IMU, STEREO (in bands), on --url: that is a sensor bus
//
// STATUS: phases `playing`, `done`; gauge played_s; counters unpaired/left, unpaired/right, dropped/STEREO/unreadable

#include <filesystem>
#include <optional>

#include "procs/common/process.h"
#include "procs/player/asl_folder.h"
#include "procs/player/options.h"

namespace covey {

class AslNode {
 public:
  AslNode(Process& process, const PlayerOptions& options);

 private:
  void publish_due();
  void publish_imu();
  void publish_stereo();
  void load_next();
  Utime due(Utime utime) const;
  std::optional<Utime> next_utime() const;
  void show_progress();

  Process& process_;
  double speed_;
  AslFolder asl_;
  std::size_t next_imu_ = 0;
  std::size_t next_picture_ = 0;
  std::optional<stereo_t> loaded_;  // the next picture, decoded before it is due
  Utime start_ = 0;
  Utime first_ = 0;
  Utime not_before_ = 0;  // what was sent needs this long to be received
};

// The same as an LCM log, without waiting (procs/common/sensor_log.h). Throws InputError.
void convert_asl(const std::filesystem::path& folder, const std::filesystem::path& log);

}  // namespace covey
