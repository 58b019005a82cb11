// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The one loop of a process: descriptors, timers, posted work and signals, all on the calling thread, one
// after the other.
//
// Live, time is the system clock and run() waits in poll(). When a log is added, time is virtual: run() takes
// the events of all logs in order of time, runs the timers that are due before each event first, and looks at
// no clock and no descriptor, so that the same logs give the same calls in the same order. Virtual time never
// runs backwards; after the last event it goes on for kLogTailUs, so that what an event set off can finish;
// where it jumps by more than kLogJumpUs, periodic timers fire once and not a million times.
//
// SIGINT and SIGTERM end run() cleanly; a second one ends the process at once, even from within a long
// handler.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/base/time.h"

namespace covey {

constexpr Utime kLogTailUs = 1'000'000;
constexpr Utime kLogJumpUs = 3'600'000'000;

// Events that carry their own time: a log.
class EventSource {
 public:
  virtual ~EventSource() = default;
  virtual std::optional<Utime>
  next_time() = 0;  // of the event that deliver() would hand out; none at the end
  virtual void deliver() = 0;
};

class EventLoop {
 public:
  using Handler = std::function<void()>;
  using TimerId = std::uint64_t;

  EventLoop();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  Utime now() const;  // us; live: system clock; from a log: event time

  void add_fd(int fd, Handler handler);  // called while fd is readable
  void remove_fd(int fd);
  TimerId call_every(Utime period_us,
                     Handler handler);  // first after one period; periods that were missed are skipped
  TimerId call_at(Utime when, Handler handler);  // once, as soon as now() >= when
  void cancel(TimerId timer);
  void post(Handler handler);  // in the next turn of the loop, in order
  void add_source(std::unique_ptr<EventSource> source);

  // Takes SIGINT and SIGTERM over, for one loop of the process.
  void handle_signals();

  // Until stop(), before or during it, a signal or the end of the logs. Can be called again; after a signal it returns
  // at once.
  int run();
  void stop(int exit_code = 0);  // run() returns after the current handler
  bool interrupted() const;      // by a signal: nothing more is begun, however much is due

 private:
  struct Timer {
    Utime due = 0;
    Utime period_us = 0;  // 0: once
    Handler handler;
  };
  struct Poller {
    int fd = -1;
    Handler handler;
  };

  void run_live();
  void wait_and_dispatch();
  void run_logs();
  EventSource* earliest_source() const;
  void run_posted();
  void run_timers_until(Utime time);
  void fire(TimerId id);
  void move(TimerId id, Utime due);
  void skip_periods_until(Utime time);
  void follow_clock_steps();

  std::map<TimerId, Timer> timers_;
  std::set<std::pair<Utime, TimerId>> due_;  // in the order in which they fire
  TimerId next_timer_ = 1;
  std::vector<Poller> pollers_;
  std::vector<Handler> posted_;
  std::vector<std::unique_ptr<EventSource>> sources_;
  Utime virtual_now_ = 0;
  Utime clock_offset_us_ = 0;
  int signal_pipe_ = -1;
  bool stopping_ = false;
  int exit_code_ = 0;
};

}  // namespace covey
