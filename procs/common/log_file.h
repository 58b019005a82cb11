// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// LCM logs, read and written through lcm::LogFile. The file:// provider is not used: its publish is silent,
// its receive time is the wall clock, and its descriptor stays readable at the end.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/base/bytes.h"
#include "procs/common/event_loop.h"

namespace lcm {
class LogFile;
}

namespace covey {

// Throws InputError where the file cannot be read or has no event. What is torn or damaged, at the end or in the
// middle, and events at impossible times are left out, with one warning.
class LogReader : public EventSource {
 public:
  using Handler = std::function<void(const std::string& channel, const Bytes& bytes)>;

  LogReader(const std::string& file, Handler handler);
  ~LogReader() override;

  std::optional<Utime> next_time() override;
  void deliver() override;

 private:
  void advance();
  bool at_end() const;

  std::string file_;
  Handler handler_;
  std::unique_ptr<lcm::LogFile> log_;
  std::optional<Utime> time_;
  std::string channel_;
  Bytes bytes_;
  bool said_damaged_ = false;
};

// Throws InputError where the file cannot be written.
class LogRecorder {
 public:
  explicit LogRecorder(const std::string& file);
  ~LogRecorder();
  void write(Utime time, const std::string& channel, const Bytes& bytes);
  void flush();                        // to the system: what was written before survives this process
  bool good() const { return good_; }  // false after a failed write, e.g. on a full disk

 private:
  std::unique_ptr<lcm::LogFile> log_;
  bool good_ = true;
};

}  // namespace covey
