// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a robot says about which bags of words it has: for each run of keyframes (a robot's segment) the ids, from the newest on.
//
// Coded as lengths of what is there and what is missing in turn, range-coded (naturals.h): a run without a gap takes a few bytes. Where
// a run has more stretches than kMostStretches only the newest are said; `said_from` tells from which id on.

#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/place/id_ranges.h"

namespace covey::place {

constexpr std::int32_t kMostId = 1'000'000;  // of a keyframe; what naturals.h can code
constexpr int kMostStretches = 64;           // of one run
constexpr int kMostRuns = 48;                // in one message
constexpr int kMostSaid = 200;               // stretches in one message, which then fits a datagram

struct RunInventory {
  int robot = 0;
  Utime segment = 0;
  IdRanges ids = {};
  int said_from = 0;  // nothing is said of ids below
};

struct Inventory {
  std::vector<RunInventory> runs;
  bool whole = true;  // runs that are not listed are not there; else nothing is said of them
};

// The ids alone; none of the runs is empty.
std::vector<std::uint8_t> encode_ids(const std::vector<RunInventory>& runs);
// Into runs whose robots and segments are known. Null, or what is wrong: "ids", "code".
const char* decode_ids(const std::vector<std::uint8_t>& code, std::vector<RunInventory>& runs);

}  // namespace covey::place
