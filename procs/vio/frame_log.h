// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What became of every picture set, as CSV (--frames): one line for each, in the order in which they were worked on or given up.
//
//   utime_us,front_end_ms,frame_ms,tracks,stereo,used,fate
//
// Milliseconds are CPU time; `frame_ms` includes the front end. fate: a phase of STATUS, or why the set was dropped (then all else is 0).

#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/time.h"

namespace covey {

struct FrameRecord {
  Utime utime = 0;
  double front_end_ms = 0.0;
  double frame_ms = 0.0;
  int tracks = 0;
  int stereo = 0;  // of them, matched with the right picture
  int used = 0;    // of them, that agree with the map
  std::string fate;
};

class FrameLog {
 public:
  // Nothing is written where the path is empty. InputError where the file cannot be.
  explicit FrameLog(const std::filesystem::path& file);

  void write(const FrameRecord& record);

 private:
  std::ofstream stream_;
};

}  // namespace covey
