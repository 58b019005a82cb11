// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A bus that is worse than it is: drops, doubles and delays what arrives, for tests. The fate of the n-th
// message of a channel depends on the seed, the channel and n alone, so that a run from a log is repeatable.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace covey {

struct BusFaults {
  double drop = 0.0;       // probability
  double duplicate = 0.0;  // probability of a second copy
  double delay_ms = 0.0;   // each copy is delayed by a uniform draw from [0, delay_ms]: this reorders too
  std::uint64_t seed = 1;
  bool any() const { return drop > 0.0 || duplicate > 0.0 || delay_ms > 0.0; }
};

// "drop=0.1,duplicate=0.05,delay_ms=50,seed=1", any of them. Throws InputError.
BusFaults parse_bus_faults(const std::string& text);

class FaultInjector {
 public:
  explicit FaultInjector(BusFaults faults) : faults_(faults) {}
  // The delays of the copies of the next message on `channel`; empty: it is dropped.
  std::vector<Utime> next(const std::string& channel);
  const BusFaults& faults() const { return faults_; }

 private:
  BusFaults faults_;
  std::map<std::string, std::uint64_t> messages_;
};

}  // namespace covey
