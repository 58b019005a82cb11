// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Image sets travel as numbered bands of at most 60 kB: with the receive buffer of a stock system (212,992 bytes) 7 of 100 raw stereo
// pairs arrive, and all of them in bands that are sent 0.5 ms apart (DECISIONS.md, buses). A set that misses a band is given up when
// a newer one is complete, or when too many wait; a reader counts what it lost.

#include <covey/band_t.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/time.h"

namespace covey {

constexpr std::int32_t kBandBytes = 60'000;
constexpr Utime kBandSpacingUs = 500;

std::vector<band_t> split_bands(const Bytes& message, Utime utime, std::int64_t run, std::int32_t number);

class BandAssembler {
 public:
  struct Result {
    std::optional<Bytes> message;  // this band was the last one missing
    std::string dropped;  // why this band was not used: "impossible", "duplicate", "old"; empty: it was
    int incomplete = 0;   // image sets that were given up for missing bands
    int missing = 0;      // image sets of which nothing has come at all
  };
  Result add(band_t band);

 private:
  struct Partial {
    Bytes bytes;
    std::vector<bool> have;
    int left = 0;
  };
  static constexpr std::size_t kMostPartial = 3;
  static constexpr std::int32_t kMostBytes = 64 << 20;

  void give_up_before(std::int32_t number, Result& result);

  std::int64_t run_ = 0;
  std::int32_t next_ = 0;  // sets below are delivered or given up
  bool started_ = false;
  std::map<std::int32_t, Partial> partial_;
};

}  // namespace covey
