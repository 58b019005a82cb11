// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Durations are seconds where people write them (keys that end in _s) and microseconds in the options. Range in
// seconds; InputError as ConfigSection::read.

#include <string>

#include "core/base/config.h"
#include "core/base/time.h"

namespace covey {

inline void read_seconds(ConfigSection& section, const std::string& key, Utime& value, double lowest,
                         double highest) {
  double seconds = to_seconds(value);
  section.read(key, seconds, lowest, highest);
  value = from_seconds(seconds);
}

}  // namespace covey
