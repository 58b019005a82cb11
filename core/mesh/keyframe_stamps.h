// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which keyframe of a segment was the newest at a stamp.

#include <algorithm>
#include <cstdint>
#include <map>
#include <vector>

#include "core/base/time.h"

namespace covey::mesh {

class KeyframeStamps {
 public:
  // In the order of their ids; an id that does not follow the last of its segment by one or more has no effect.
  void add(std::int64_t segment, std::int32_t id, Utime utime) {
    std::vector<Stamp>& stamps = segments_[segment];
    if (stamps.empty() || (id > stamps.back().id && utime > stamps.back().utime))
      stamps.push_back({utime, id});
  }

  // -1 where there is none yet.
  std::int32_t newest_at(std::int64_t segment, Utime utime) const {
    const auto found = segments_.find(segment);
    if (found == segments_.end()) return -1;
    const std::vector<Stamp>& stamps = found->second;
    const auto after = std::upper_bound(stamps.begin(), stamps.end(), utime,
                                        [](Utime time, const Stamp& stamp) { return time < stamp.utime; });
    return after == stamps.begin() ? -1 : (after - 1)->id;
  }

 private:
  struct Stamp {
    Utime utime = 0;
    std::int32_t id = 0;
  };
  std::map<std::int64_t, std::vector<Stamp>> segments_;
};

}  // namespace covey::mesh
