// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Runs of two to four lcd agents through whatever their seed brings: 0-40 % loss, delays and jitter to half a second, doubles, on a bare
// network or over radio_bridge's links with a rate; pairs and robots out of range for up to 80 s, lcds that are killed and come back with what
// they had on disk (or without it, once all that they found has been acknowledged), bridges that start anew, odometry that starts anew.
//
// At the end, when all are in range again, both ends of each pair must hold the same closures, all of them right, and who compares must have
// every bag of the other.

#include <cstdint>
#include <string>

namespace covey::place {

struct LcdSweepRun {
  std::string story;    // what the seed brought
  std::string failure;  // empty: everything is as above
  bool radio = false;
  int closures = 0;  // between robots
  int bags_got = 0;  // copies
  int bags_in_vain = 0;
  double seconds = 0.0;  // of virtual time
};

LcdSweepRun run_lcd_seed(std::uint64_t seed);

}  // namespace covey::place
