// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/event_loop.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <string>

namespace covey {
namespace {

using Trace = std::vector<std::string>;

// Events at given times.
class Script : public EventSource {
 public:
  Script(std::vector<Utime> times, std::function<void()> handler)
      : times_(std::move(times)), handler_(std::move(handler)) {}
  std::optional<Utime> next_time() override {
    if (next_ == times_.size()) return std::nullopt;
    return times_[next_];
  }
  void deliver() override {
    ++next_;
    handler_();
  }

 private:
  std::vector<Utime> times_;
  std::function<void()> handler_;
  std::size_t next_ = 0;
};

TEST_CASE("Live, descriptors, timers and posted work take turns") {
  EventLoop loop;
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  int read_bytes = 0;
  int periods = 0;
  bool posted = false;
  loop.add_fd(ends[0], [&] {
    char byte = 0;
    read_bytes += static_cast<int>(read(ends[0], &byte, 1));
  });
  loop.post([&] { posted = true; });
  const Utime start = loop.now();
  loop.call_every(2'000, [&] {
    ++periods;
    REQUIRE(write(ends[1], "x", 1) == 1);
  });
  loop.call_at(start + 50'000, [&] { loop.stop(3); });
  CHECK(loop.run() == 3);
  CHECK(posted);
  CHECK(periods >= 2);
  CHECK(periods <= 25);
  CHECK(read_bytes >= periods - 1);
  CHECK(loop.now() >= start + 50'000);
  close(ends[0]);
  close(ends[1]);
}

TEST_CASE("A signal ends a log run, even among timers that never end") {
  EventLoop loop;
  loop.handle_signals();
  loop.add_source(std::make_unique<Script>(std::vector<Utime>{1'000'000, 2'000'000}, [] {}));
  int fired = 0;
  const std::function<void()> again = [&] {
    if (++fired == 10) raise(SIGTERM);
    if (fired < 1000) loop.call_at(loop.now(), again);
  };
  loop.call_at(1'000'000, again);
  CHECK(loop.run() == 0);
  CHECK(fired == 10);
}

TEST_CASE("A timer may cancel itself or another, and set new ones") {
  EventLoop loop;
  int first = 0;
  int second = 0;
  EventLoop::TimerId victim = loop.call_every(1'000, [&] { ++second; });
  EventLoop::TimerId self = 0;
  self = loop.call_every(500, [&] {
    ++first;
    loop.cancel(victim);
    loop.cancel(self);
    loop.call_at(loop.now() + 5'000, [&] { loop.stop(); });
  });
  CHECK(loop.run() == 0);
  CHECK(first == 1);
  CHECK(second == 0);
}

TEST_CASE("A signal ends the loop cleanly") {
  EventLoop loop;
  loop.handle_signals();
  loop.call_at(loop.now() + 1'000, [] { raise(SIGTERM); });
  CHECK_FALSE(loop.interrupted());
  CHECK(loop.run() == 0);
  CHECK(loop.interrupted());
  bool called = false;
  loop.call_at(loop.now(), [&] { called = true; });
  CHECK(loop.run() == 0);  // again: at once
  CHECK_FALSE(called);
}

Trace run_script() {
  EventLoop loop;
  Trace trace;
  const auto note = [&](const std::string& what) { trace.push_back(what + std::to_string(loop.now())); };
  loop.add_source(std::make_unique<Script>(std::vector<Utime>{100, 250, 250, 240, 1000}, [&] {
    note("a");
    loop.post([&] { note("posted"); });
  }));
  loop.add_source(std::make_unique<Script>(std::vector<Utime>{50, 250}, [&] { note("b"); }));
  loop.call_every(100, [&] { note("t"); });
  loop.call_at(250, [&] { note("once"); });
  loop.call_at(1000 + kLogTailUs / 2, [&] {
    note("tail");
    loop.stop();
  });
  CHECK(loop.run() == 0);
  return trace;
}

TEST_CASE("From a log, time is the events' and timers run between them, always in the same order") {
  const Trace trace = run_script();
  CHECK(trace == run_script());
  const Trace expected{"b50",       "a100", "posted100", "t150", "t250",      "once250", "a250",
                       "posted250", "a250", "posted250", "a250", "posted250", "b250",    "t350"};
  REQUIRE(trace.size() > expected.size());
  CHECK(Trace(trace.begin(), trace.begin() + static_cast<std::ptrdiff_t>(expected.size())) == expected);
  CHECK(trace.back() == "tail" + std::to_string(1000 + kLogTailUs / 2));
}

TEST_CASE("A log that jumps by years does not run millions of periods") {
  EventLoop loop;
  int periods = 0;
  loop.add_source(std::make_unique<Script>(std::vector<Utime>{0, 1'700'000'000'000'000}, [] {}));
  loop.call_every(20'000, [&] { ++periods; });
  loop.run();
  CHECK(periods <= 2 + kLogTailUs / 20'000);
}

}  // namespace
}  // namespace covey
