// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What receivers with stock buffers take: 60 kB each 0.5 ms, and 90 small messages while a reader is late by 18 ms.

#include <algorithm>
#include <cstddef>

#include "core/base/time.h"

namespace covey {

inline Utime time_to_receive(std::size_t bytes) {
  constexpr Utime kNsPerByte = 8;
  constexpr Utime kUsPerMessage = 200;
  return std::max(kUsPerMessage, static_cast<Utime>(bytes) * kNsPerByte / 1000);
}

}  // namespace covey
