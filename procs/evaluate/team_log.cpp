// SPDX-License-Identifier: BSD-3-Clause
#include "procs/evaluate/team_log.h"

#include <algorithm>
#include <covey/loop_weights_t.hpp>
#include <map>
#include <tuple>

#include "core/base/bytes.h"
#include "core/pgo/trajectories.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"

namespace covey {
namespace {

using Closure = std::tuple<int, int, int, int>;  // robot and index of the first pose, of the second
using Weights =
    std::map<Closure, std::vector<double>>;  // several: measured several times, in the order of the graph

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

  const Weights& weights() const { return weights_; }

 private:
  void add(const loop_weights_t& part) {
    for (int k = 0; k < part.n; ++k) {
      weights_[{part.robots_a[k], part.ids_a[k], part.robots_b[k], part.ids_b[k]}].push_back(part.weights[k]);
    }
  }

  Utime ended_ = 0;  // of the round in parts_
  std::map<int, loop_weights_t> parts_;
  Weights weights_;
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

std::vector<bool> kept_in_logs(const pgo::PoseGraph& graph, const std::vector<std::filesystem::path>& logs) {
  const std::map<int, LastRound> rounds = read_last_rounds(logs);
  std::map<Closure, std::size_t> copies;
  std::vector<bool> kept;
  for (const pgo::Edge& edge : graph.edges) {
    if (edge.kind == pgo::EdgeKind::kOdometry) {
      kept.push_back(true);
      continue;
    }
    const Closure closure{edge.from.robot, edge.from.index, edge.to.robot, edge.to.index};
    const std::size_t copy = copies[closure]++;
    const auto owner = rounds.find(std::min(edge.from.robot, edge.to.robot));
    double weight = 0.0;
    if (owner != rounds.end()) {
      const auto said = owner->second.weights().find(closure);
      if (said != owner->second.weights().end() && copy < said->second.size()) weight = said->second[copy];
    }
    kept.push_back(weight > 0.5);
  }
  return kept;
}

}  // namespace covey
