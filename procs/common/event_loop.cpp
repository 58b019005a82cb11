// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/event_loop.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <utility>

#include "core/base/error.h"

namespace covey {
namespace {

constexpr Utime kClockStepUs = 500'000;

Utime system_now() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

Utime steady_now() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Only what is allowed in a signal handler: the pipe wakes poll(), the second signal does not wait for
// anything.
int wake_pipe_write_end = -1;
volatile sig_atomic_t signals_seen = 0;

void on_signal(int) {
  const int saved_errno = errno;
  signals_seen = signals_seen + 1;
  if (signals_seen > 1) _exit(1);
  const char byte = 0;
  [[maybe_unused]] const auto written = write(wake_pipe_write_end, &byte, 1);
  errno = saved_errno;
}

}  // namespace

EventLoop::EventLoop() : clock_offset_us_(system_now() - steady_now()) {}

EventLoop::~EventLoop() {
  if (signal_pipe_ < 0) return;
  signal(SIGINT, SIG_DFL);
  signal(SIGTERM, SIG_DFL);
  close(signal_pipe_);
  close(std::exchange(wake_pipe_write_end, -1));
}

Utime EventLoop::now() const { return sources_.empty() ? system_now() : virtual_now_; }

void EventLoop::add_fd(int fd, Handler handler) { pollers_.push_back({fd, std::move(handler)}); }

void EventLoop::remove_fd(int fd) {
  std::erase_if(pollers_, [fd](const Poller& poller) { return poller.fd == fd; });
}

EventLoop::TimerId EventLoop::call_every(Utime period_us, Handler handler) {
  COVEY_CHECK(period_us > 0);
  const TimerId id = next_timer_++;
  const Utime due = now() + period_us;
  timers_[id] = {due, period_us, std::move(handler)};
  due_.insert({due, id});
  return id;
}

EventLoop::TimerId EventLoop::call_at(Utime when, Handler handler) {
  const TimerId id = next_timer_++;
  timers_[id] = {when, 0, std::move(handler)};
  due_.insert({when, id});
  return id;
}

void EventLoop::cancel(TimerId timer) {
  const auto found = timers_.find(timer);
  if (found == timers_.end()) return;
  due_.erase({found->second.due, timer});
  timers_.erase(found);
}

void EventLoop::post(Handler handler) { posted_.push_back(std::move(handler)); }

void EventLoop::add_source(std::unique_ptr<EventSource> source) {
  COVEY_CHECK(timers_.empty() || !sources_.empty());  // the clock must not change under a timer
  const std::optional<Utime> start = source->next_time();
  if (start) virtual_now_ = sources_.empty() ? *start : std::min(virtual_now_, *start);
  sources_.push_back(std::move(source));
}

void EventLoop::handle_signals() {
  COVEY_CHECK(wake_pipe_write_end < 0);
  std::array<int, 2> ends{};
  COVEY_CHECK(pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) == 0);
  signal_pipe_ = ends[0];
  wake_pipe_write_end = ends[1];
  signals_seen = 0;
  add_fd(signal_pipe_, [this] { stop(); });
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

bool EventLoop::interrupted() const { return signal_pipe_ >= 0 && signals_seen > 0; }

int EventLoop::run() {
  if (sources_.empty()) {
    run_live();
  } else {
    run_logs();
  }
  stopping_ = false;
  return exit_code_;
}

void EventLoop::stop(int exit_code) {
  if (stopping_) return;
  stopping_ = true;
  exit_code_ = exit_code;
}

void EventLoop::run_live() {
  while (!stopping_) {
    run_posted();
    follow_clock_steps();
    run_timers_until(now());
    if (!stopping_) wait_and_dispatch();
  }
}

void EventLoop::wait_and_dispatch() {
  Utime timeout_us = kUsPerSecond;  // at least so often the clock is looked at
  if (!due_.empty()) timeout_us = std::clamp<Utime>(due_.begin()->first - now(), 0, timeout_us);
  if (!posted_.empty()) timeout_us = 0;
  std::vector<pollfd> fds;
  for (const Poller& poller : pollers_) fds.push_back({poller.fd, POLLIN, 0});
  if (poll(fds.data(), fds.size(), static_cast<int>((timeout_us + 999) / 1000)) <= 0) return;
  for (const pollfd& ready : fds) {
    if (ready.revents == 0 || stopping_) continue;
    // Looked up again, since an earlier handler may have removed it; copied, since it may remove itself.
    const auto poller = std::find_if(pollers_.begin(), pollers_.end(),
                                     [&](const Poller& candidate) { return candidate.fd == ready.fd; });
    if (poller == pollers_.end()) continue;
    const Handler handler = poller->handler;
    handler();
  }
}

void EventLoop::run_logs() {
  while (!stopping_ && !interrupted()) {
    EventSource* source = earliest_source();
    if (source == nullptr) break;
    const Utime time = std::max(virtual_now_, *source->next_time());
    if (time - virtual_now_ > kLogJumpUs) skip_periods_until(time);
    run_timers_until(time);
    if (stopping_) return;
    virtual_now_ = time;
    source->deliver();
    run_posted();
  }
  run_timers_until(virtual_now_ + kLogTailUs);
}

EventSource* EventLoop::earliest_source() const {
  EventSource* earliest = nullptr;
  std::optional<Utime> earliest_time;
  for (const auto& source : sources_) {
    const std::optional<Utime> time = source->next_time();
    if (time && (!earliest_time || *time < *earliest_time)) {
      earliest = source.get();
      earliest_time = time;
    }
  }
  return earliest;
}

// Live, one round of what is there, so that descriptors get their turn; from a log until nothing is left.
void EventLoop::run_posted() {
  do {
    for (const Handler& handler : std::exchange(posted_, {})) {
      if (stopping_) return;
      handler();
    }
  } while (!sources_.empty() && !posted_.empty() && !interrupted());
}

void EventLoop::run_timers_until(Utime time) {
  while (!stopping_ && !interrupted() && !due_.empty() && due_.begin()->first <= time) {
    const auto [due, id] = *due_.begin();
    if (!sources_.empty()) virtual_now_ = std::max(virtual_now_, due);
    fire(id);
    if (!sources_.empty()) run_posted();
  }
}

void EventLoop::fire(TimerId id) {
  Timer& timer = timers_.at(id);
  if (timer.period_us == 0) {
    const Handler handler = std::move(timer.handler);
    cancel(id);
    handler();
    return;
  }
  const Utime missed = sources_.empty() ? std::max<Utime>(0, now() - timer.due) / timer.period_us : 0;
  move(id, timer.due + (missed + 1) * timer.period_us);
  const Handler handler = timer.handler;  // it may cancel itself
  handler();
}

void EventLoop::move(TimerId id, Utime due) {
  Timer& timer = timers_.at(id);
  due_.erase({timer.due, id});
  timer.due = due;
  due_.insert({due, id});
}

void EventLoop::skip_periods_until(Utime time) {
  for (const auto& [id, timer] : timers_) {
    if (timer.period_us > 0 && timer.due < time) move(id, time);
  }
}

// Somebody set the clock: periods go on as if nothing had happened.
void EventLoop::follow_clock_steps() {
  const Utime offset = system_now() - steady_now();
  const Utime step = offset - clock_offset_us_;
  if (std::abs(step) < kClockStepUs) return;
  clock_offset_us_ = offset;
  for (const auto& [id, timer] : timers_) {
    if (timer.period_us > 0) move(id, timer.due + step);
  }
}

}  // namespace covey
