// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/log_node.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "core/base/error.h"
#include "procs/player/pace.h"

namespace covey {
namespace {

constexpr Utime kLongestBatchUs = 2'000;  // then timers and signals have their turn

std::regex compile(const std::string& expression) {
  try {
    return std::regex(expression);
  } catch (const std::regex_error&) {
    throw_input_error("--channels '{}' is not a regular expression", expression);
  }
}

}  // namespace

LogNode::LogNode(Process& process, const PlayerOptions& options)
    : process_(process),
      speed_(options.speed),
      channels_(compile(options.channels)),
      log_(options.log.string(),
           [this](const std::string& channel, const Bytes& bytes) { publish(channel, bytes); }),
      start_(process.now()),
      first_event_(log_.next_time().value_or(0)) {
  process_.status().set_phase("playing");
  process_.loop().call_every(kUsPerSecond, [this] { show_progress(); });
  process_.loop().call_at(start_, [this] { publish_due(); });
}

void LogNode::publish(const std::string& channel, const Bytes& bytes) {
  if (!std::regex_match(channel, channels_)) {
    ++left_out_;
    return;
  }
  process_.bus().publish_raw(channel, bytes);
  not_before_ = std::max(not_before_, process_.now()) + time_to_receive(bytes.size());
  ++published_;
}

Utime LogNode::due(Utime event_time) const {
  const double paced_s = speed_ == 0.0 ? 0.0 : to_seconds(event_time - first_event_) / speed_;
  return std::max(start_ + from_seconds(paced_s), not_before_);
}

void LogNode::publish_due() {
  const Utime until = process_.now() + kLongestBatchUs;
  std::optional<Utime> next = log_.next_time();
  while (next && due(*next) <= process_.now() && process_.now() < until) {
    process_.status().gauge("played_s", to_seconds(*next - first_event_));
    log_.deliver();
    next = log_.next_time();
  }
  if (next) {
    // Not in the past, which would be now again: what is left out has no pace, and others want their turn.
    process_.loop().call_at(std::max(due(*next), process_.now()), [this] { publish_due(); });
    return;
  }
  show_progress();
  process_.status().set_phase("done");
  process_.stop();
}

void LogNode::show_progress() {
  spdlog::info("{:.1f} s played, {} messages published, {} left out by --channels",
               process_.status().gauge("played_s"), published_, left_out_);
}

}  // namespace covey
