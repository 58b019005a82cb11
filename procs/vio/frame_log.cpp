// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/frame_log.h"

#include <fmt/format.h>

#include "core/base/error.h"

namespace covey {

FrameLog::FrameLog(const std::filesystem::path& file) {
  if (file.empty()) return;
  stream_.open(file);
  if (!stream_) throw_input_error("--frames {}: cannot be written", file.string());
  stream_ << "utime_us,front_end_ms,frame_ms,tracks,stereo,used,fate\n";
}

void FrameLog::write(const FrameRecord& record) {
  if (!stream_.is_open()) return;
  stream_ << fmt::format("{},{:.3f},{:.3f},{},{},{},{}\n", record.utime, record.front_end_ms, record.frame_ms,
                         record.tracks, record.stereo, record.used, record.fate);
}

}  // namespace covey
