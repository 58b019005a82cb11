// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The KEYFRAMEs that were said, on disk: DIR/vio_keyframes.lcm, an LCM log. A file that cannot be read costs what is in it, a disk that is full costs what
// a restart would gain; neither costs the run.

#include <covey/keyframe_t.hpp>
#include <filesystem>
#include <memory>
#include <vector>

#include "core/base/stream.h"
#include "procs/common/log_file.h"

namespace covey {

class KeyframeLog {
 public:
  explicit KeyframeLog(const std::filesystem::path& folder);

  // What was there at the start, in order.
  const std::vector<keyframe_t>& restored() const { return restored_; }
  bool knows(const keyframe_t& keyframe) const;
  void append(const keyframe_t& keyframe, Utime now);

 private:
  std::vector<keyframe_t> restored_;
  StreamPositions next_;
  std::unique_ptr<LogRecorder> log_;
};

}  // namespace covey
