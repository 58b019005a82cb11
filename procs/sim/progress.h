// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How far a run is, on stderr: one line that is written over on a terminal, else a line every ten seconds.

#include <chrono>
#include <string>

namespace covey {

class Progress {
 public:
  Progress(std::string what, double total_s);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(double done_s);  // of simulated time

 private:
  using Clock = std::chrono::steady_clock;

  std::string what_;
  double total_s_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_;
};

}  // namespace covey
