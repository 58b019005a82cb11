// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Runs of a small team through whatever its seed brings: 0-40 % loss, delays to 1 s, doubles, disorder; a team in which all
// hear all, a chain or another tree; partitions that heal or do not, robots that are killed and come back with what they had
// on disk or without it, or for good; data that comes in two parts.
//
// At the end all robots that are joined by links must have ended one round, with the cost and the frame of a lossless run of
// the same robots, and must name every robot that they knew and have lost. And at no time may robots publish one frame
// that is not the one of a lossless run.

#include <cstdint>
#include <string>

namespace covey::pgo {

struct SweepRun {
  std::string story;     // what the seed brought
  std::string failure;   // empty: everything is as above
  double seconds = 0.0;  // of virtual time
  int rounds = 0;
  int relayed = 0;          // messages that were passed on
  double cost_error = 0.0;  // largest, relative to the lossless run
  bool parted = false;      // some robot was apart in the end
};

SweepRun run_seed(std::uint64_t seed);

}  // namespace covey::pgo
