// SPDX-License-Identifier: BSD-3-Clause
#include "procs/evaluate/team_log.h"

#include <algorithm>
#include <covey/loop_weights_t.hpp>
#include <map>

#include "core/base/bytes.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"

namespace covey {
namespace {

// The weights that one robot said of its last round, whatever order the logs come in.
class LastRound {
 public:
  void take(const loop_weights_t& part) {
    if (part.utime < ended_) return;
    if (part.utime > ended_) parts_.clear();
    ended_ = part.utime;
    parts_[part.part] = part;
    if (static_cast<int>(parts_.size()) < part.parts) return;
    weights_.clear();
    for (const auto& [number, whole] : parts_) add(whole);
  }

  const std::vector<SaidWeight>& weights() const { return weights_; }

 private:
  void add(const loop_weights_t& part) {
    for (int k = 0; k < part.n; ++k) {
      weights_.push_back({{part.robots_a[k], part.ids_a[k]},
                          {part.robots_b[k], part.ids_b[k]},
                          part.weights[k],
                          part.residuals_sq[k]});
    }
  }

  Utime ended_ = 0;  // of the round in parts_
  std::map<int, loop_weights_t> parts_;
  std::vector<SaidWeight> weights_;
};

std::map<int, LastRound> read_last_rounds(const std::vector<std::filesystem::path>& logs) {
  std::map<int, LastRound> rounds;
  for (const auto& file : logs) {
    std::error_code unreadable;  // LogReader says so
    if (std::filesystem::file_size(file, unreadable) == 0 && !unreadable) continue;
    LogReader log(file.string(), [&](const std::string& channel, const Bytes& bytes) {
      loop_weights_t message{};
      if (channel == kLoopWeights.name && decode(bytes, message)) rounds[message.robot].take(message);
    });
    while (log.next_time()) log.deliver();
  }
  return rounds;
}

}  // namespace

std::vector<SaidWeight> weights_in_logs(const std::vector<std::filesystem::path>& logs) {
  std::vector<SaidWeight> owned;
  for (const auto& [robot, round] : read_last_rounds(logs)) {
    for (const SaidWeight& each : round.weights()) {
      if (robot == std::min(each.from.robot, each.to.robot)) owned.push_back(each);
    }
  }
  return owned;
}

}  // namespace covey
