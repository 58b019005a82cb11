// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/keyframe_log.h"

#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "procs/common/channels.h"

namespace covey {
namespace {

std::vector<keyframe_t> read_keyframes(const std::filesystem::path& file) {
  std::vector<keyframe_t> keyframes;
  if (!std::filesystem::exists(file)) return keyframes;
  try {
    LogReader reader(file.string(), [&](const std::string& channel, const Bytes& bytes) {
      keyframe_t keyframe{};
      if (channel == kKeyframe.name && decode(bytes, keyframe)) keyframes.push_back(keyframe);
    });
    while (reader.next_time()) reader.deliver();
  } catch (const InputError& error) {
    spdlog::warn("{}: nothing can be read back, starting without", error.what());
  }
  return keyframes;
}

}  // namespace

// Rewritten on each start, so that a cut-off end is not followed by good events.
KeyframeLog::KeyframeLog(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "vio_keyframes.lcm";
  const std::filesystem::path fresh = folder / "vio_keyframes.lcm.new";
  log_ = std::make_unique<LogRecorder>(fresh.string());
  for (const keyframe_t& keyframe : read_keyframes(file)) {
    const std::int32_t next = next_[keyframe.segment];
    if (keyframe.id != next) continue;  // a stream has no gaps
    append(keyframe, keyframe.utime);
    restored_.push_back(keyframe);
  }
  log_->flush();
  std::filesystem::rename(fresh, file);
}

bool KeyframeLog::knows(const keyframe_t& keyframe) const {
  const auto next = next_.find(keyframe.segment);
  return next != next_.end() && keyframe.id < next->second;
}

void KeyframeLog::append(const keyframe_t& keyframe, Utime now) {
  log_->write(now, kKeyframe.name, encode(keyframe));
  log_->flush();
  next_[keyframe.segment] = keyframe.id + 1;
}

}  // namespace covey
