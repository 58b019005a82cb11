// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The process's CPU time since it was made: other programs on the machine do not count.

#include <ctime>

namespace covey::bench {

class CpuClock {
 public:
  double seconds() const { return static_cast<double>(std::clock() - begin_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t begin_ = std::clock();
};

}  // namespace covey::bench
