// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/output.h"

#include <spdlog/spdlog.h>

#include "procs/common/channels.h"
#include "procs/vio/messages.h"

namespace covey {

VioOutput::VioOutput(Process& process) : process_(process) {
  if (!process_.state_dir().empty()) {
    log_.emplace(process_.state_dir());
    for (const keyframe_t& keyframe : log_->restored()) process_.bus().publish(kKeyframe, keyframe);
    if (!log_->restored().empty())
      spdlog::info("said {} keyframes of earlier segments again", log_->restored().size());
  }
  process_.on_stop([this] { write_trajectory(); });
}

void VioOutput::publish_state(const vio::VioState& state) {
  process_.bus().publish(kState, to_message(state, process_.robot()));
}

void VioOutput::publish_keyframe(const vio::VioKeyframe& keyframe) {
  const keyframe_t message = to_message(keyframe, process_.robot());
  if (log_ && log_->knows(message)) return;  // the same log, played again
  process_.bus().publish(kKeyframe, message);
  if (log_) log_->append(message, process_.now());
  process_.status().gauge("keyframes", keyframe.id + 1.0);
}

void VioOutput::add_to_trajectory(const vio::VioState& state) {
  if (!trajectory_.empty() && state.utime <= trajectory_.back().utime) return;
  if (state.segment != segment_) ++segments_;
  segment_ = state.segment;
  if (!process_.tum_path().empty()) trajectory_.push_back({state.utime, state.state.T_W_B});
  process_.status().gauge("segments", segments_);
}

void VioOutput::write_trajectory() const {
  if (process_.tum_path().empty()) return;
  write_tum(process_.tum_path(), trajectory_);
  spdlog::info("{}: {} poses", process_.tum_path().string(), trajectory_.size());
  if (segments_ > 1) {
    spdlog::warn("{}: {} segments, each in an odometry frame of its own", process_.tum_path().string(),
                 segments_);
  }
}

}  // namespace covey
