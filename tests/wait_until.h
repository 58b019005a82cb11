// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Runs a test's event loop until something holds, or patience ends: whole processes are waited for, never slept for.

#include <functional>

#include "procs/common/event_loop.h"

namespace covey {

inline bool wait_until(EventLoop& loop, double patience_s, const std::function<bool()>& done) {
  const Utime end = loop.now() + from_seconds(patience_s);
  bool is_done = false;
  const auto check = loop.call_every(10'000, [&] {
    is_done = done();
    if (is_done || loop.now() > end) loop.stop();
  });
  loop.run();
  loop.cancel(check);
  return is_done;
}

}  // namespace covey
