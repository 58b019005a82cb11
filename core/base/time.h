// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Time is int64 microseconds (utime), always handed in: core has no clock. A measurement's utime is when it was taken.

#include <cstdint>

namespace covey {

using Utime = std::int64_t;

constexpr Utime kUsPerSecond = 1'000'000;

constexpr double to_seconds(Utime duration_us) { return static_cast<double>(duration_us) * 1e-6; }
constexpr Utime from_seconds(double seconds) {
  return static_cast<Utime>(seconds * 1e6 + (seconds < 0 ? -0.5 : 0.5));
}

}  // namespace covey
