// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a dpgo must not lose with its process, under --state:
//
//   dpgo_graph.lcm     the KEYFRAMEs and LOOPs that it has taken, an LCM log that grows
//   dpgo_solution.lcm  of the last round: DPGO_BEACON (which round, of what graph), DPGO_JOIN (the segments, with the name of
//                      the frame that they are in; as peers, the robots in it), what was published of it (TRAJECTORY, LOOP_WEIGHTS) and said of it
//                      (gauges of a STATUS); replaced as a whole
//
// Both are read back at the start. A log whose end was cut off, or is not what it should be, is good up to there.

#include <covey/dpgo_beacon_t.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/stream.h"
#include "core/pgo/dgnc_agent.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"

namespace covey {

// What a round left behind.
struct SavedRound {
  pgo::Solution solution;
  std::vector<trajectory_t> trajectory;
  std::vector<loop_weights_t> loop_weights;
  std::map<std::string, double> gauges;
};

class GraphLog {
 public:
  // Calls `take` for everything that was kept, in its order, and leaves the log open for more. Throws InputError where the
  // folder cannot be written.
  using Take = std::function<void(const std::string& channel, const Bytes& bytes)>;
  GraphLog(std::filesystem::path folder, const Take& take);

  void append(const keyframe_t& keyframe, Utime now);
  void append(const loop_t& loop, Utime now);

  // Of both streams: the number after the last one kept.
  const StreamPositions& keyframes() const { return keyframes_; }
  const StreamPositions& loops() const { return loops_; }

  void save(const SavedRound& round, Utime now);
  std::optional<SavedRound> load_round() const;  // none where anything of it is missing

 private:
  void write_round(const SavedRound& round, Utime now) const;

  std::filesystem::path folder_;
  std::unique_ptr<LogRecorder> log_;
  StreamPositions keyframes_;
  StreamPositions loops_;
};

}  // namespace covey
