// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/pose_graph_node.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/pgo/robot_csv.h"
#include "procs/common/channels.h"

namespace covey {
namespace {

constexpr Utime kTickUs = 5'000;
// Messages a tick, at most: stock receive buffers of 212,992 bytes hold about 90 small ones, and a reader may be late by
// some ticks.
constexpr int kBurst = 10;

// When the first of this robot's players was started. A disk that is full costs what a restart would gain, not the run.
Utime first_start(const std::filesystem::path& folder, Utime now) {
  if (folder.empty()) return now;
  const std::filesystem::path file = folder / "player_start_utime.txt";
  if (Utime saved = 0; std::ifstream(file) >> saved && saved > 0) return std::min(saved, now);
  std::filesystem::path fresh = file;
  fresh += ".new";
  std::ofstream(fresh) << now << '\n';
  std::error_code failed;
  std::filesystem::rename(fresh, file, failed);
  if (failed) spdlog::warn("{}: {}; a restart will begin anew", file.string(), failed.message());
  return now;
}

}  // namespace

PoseGraphNode::PoseGraphNode(Process& process, const PlayerOptions& options)
    : process_(process),
      speed_(options.speed),
      messages_(sim::front_end_messages(pgo::read_robot_csv(options.pose_graph), process.robot())),
      start_(first_start(process.state_dir(), process.now())) {
  process_.status().set_phase("playing");
  timer_ = process_.loop().call_every(kTickUs, [this] { publish_due(); });
}

double PoseGraphNode::recorded_s(std::size_t message) const {
  return to_seconds(sim::utime_of(messages_[message]) - sim::utime_of(messages_.front()));
}

bool PoseGraphNode::is_due() const {
  if (next_ >= messages_.size()) return false;
  return speed_ == 0.0 || recorded_s(next_) <= to_seconds(process_.now() - start_) * speed_;
}

void PoseGraphNode::publish_due() {
  if (!is_due()) return;
  for (int sent = 0; sent < kBurst && is_due(); ++sent) publish_next();
  process_.status().gauge("played_s", recorded_s(next_ - 1));
  if (next_ < messages_.size()) return;
  spdlog::info("played {} messages; answering RESEND until stopped", messages_.size());
  process_.status().set_phase("done");
  process_.loop().cancel(timer_);
}

void PoseGraphNode::publish_next() {
  const sim::FrontEndMessage& message = messages_[next_++];
  if (const auto* keyframe = std::get_if<keyframe_t>(&message)) {
    process_.bus().publish(kKeyframe, *keyframe);
  } else {
    process_.bus().publish(kLoop, std::get<loop_t>(message));
  }
}

}  // namespace covey
