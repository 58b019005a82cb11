// SPDX-License-Identifier: BSD-3-Clause
#include "procs/sim/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace covey {

Progress::Progress(std::string what, double total_s)
    : what_(std::move(what)),
      total_s_(total_s),
      terminal_(isatty(STDERR_FILENO) == 1),
      next_(start_ + std::chrono::milliseconds(terminal_ ? 500 : 10'000)) {}

Progress::~Progress() {
  if (terminal_ && shown_) fmt::print(stderr, "\r\x1b[K");
}

void Progress::show(double done_s) {
  const Clock::time_point now = Clock::now();
  if (now < next_ || done_s <= 0.0) return;
  next_ = now + std::chrono::milliseconds(terminal_ ? 200 : 10'000);
  const double spent_s = std::chrono::duration<double>(now - start_).count();
  const std::string line = fmt::format("sim: {}: {:.1f} of {:.1f} s, {:.0f} s left", what_, done_s, total_s_,
                                       spent_s * (total_s_ - done_s) / done_s);
  fmt::print(stderr, "{}{}{}", terminal_ ? "\r\x1b[K" : "", line, terminal_ ? "" : "\n");
  std::fflush(stderr);
  shown_ = true;
}

}  // namespace covey
