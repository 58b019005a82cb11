// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The robot's side of distributed pose-graph optimisation, wired to its bus.
//
//   reads   KEYFRAME, LOOP (streams); IN_DPGO_* (the other robots' dpgo)
//   writes  OUT_DPGO_*; after each round, and when one was read back from --state, TRAJECTORY and LOOP_WEIGHTS; after each
//           round the --tum file; STATUS
//
// STATUS: phase `idle` (all that is known is solved), `waiting` (for a round to begin) or `round`; gauges keyframes, loops
// (known); of the last round solved_keyframes, solved_loops, kept_loops, cost, gradient, weights_zero, weights_between,
// weights_one (this robot's share), round, robots, updates, rejected_pairs (robots with whom it has closures and kept none),
// round_s, round_kb; of each other robot R heard of since the start silent_s/R (since it was heard) and together/R (1: in one
// frame with this one by the last round).

#include <optional>
#include <utility>
#include <vector>

#include "core/pgo/dgnc_agent.h"
#include "procs/common/process.h"
#include "procs/dpgo/graph_log.h"

namespace covey {

class DpgoNode {
 public:
  explicit DpgoNode(Process& process);

 private:
  template <typename T>
  void listen(const RadioChannel<T>& channel);
  void follow_log();
  void on_keyframe(const keyframe_t& message);
  void on_loop(const loop_t& message);
  bool take(const keyframe_t& message);
  bool take(const loop_t& message);
  void work();
  pgo::AgentOptions agent_options();
  void publish_outgoing();
  void take_result(const pgo::RoundResult& result);
  void publish(const SavedRound& round);
  void restore();
  void publish_gauges();
  void watch_team();

  Process& process_;
  pgo::DgncAgent agent_;
  std::optional<GraphLog> log_;
  bool work_posted_ = false;
  std::vector<std::pair<int, pgo::Apart>> said_apart_;  // as the log has it
};

}  // namespace covey
