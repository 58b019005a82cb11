// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Publishes an LCM log again, at its own pace times --speed, and ends with it.
//
// reads   nothing
// writes  the log's channels that match --channels, byte for byte; numbered streams with the log's own
// STREAM_HEADs, and
//         nobody answers RESEND

#include <cstdint>
#include <optional>
#include <regex>

#include "procs/common/log_file.h"
#include "procs/common/process.h"
#include "procs/player/options.h"

namespace covey {

class LogNode {
 public:
  LogNode(Process& process, const PlayerOptions& options);

 private:
  void publish(const std::string& channel, const Bytes& bytes);
  void publish_due();
  void show_progress();
  Utime due(Utime event_time) const;

  Process& process_;
  double speed_;
  std::regex channels_;
  LogReader log_;
  Utime start_ = 0;
  Utime first_event_ = 0;
  Utime not_before_ = 0;  // what was sent needs this long to be received
  std::int64_t published_ = 0;
  std::int64_t left_out_ = 0;
};

}  // namespace covey
