// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/pose_history.h"

#include <algorithm>

namespace covey::mesh {

bool PoseHistory::add(const TimedPose& pose) {
  if (!poses_.empty() && pose.utime <= poses_.back().utime) {
    if (pose.segment == poses_.back().segment) return false;
    poses_.clear();
  }
  poses_.push_back(pose);
  while (pose.utime - poses_.front().utime > from_seconds(options_.length_s)) poses_.pop_front();
  return true;
}

PoseLookup PoseHistory::at(Utime utime, TimedPose& found) const {
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), utime,
                                      [](const TimedPose& pose, Utime time) { return pose.utime < time; });
  if (after == poses_.end()) return PoseLookup::kNotYet;
  if (after->utime == utime) {
    found = *after;
    return found.coasting ? PoseLookup::kCoasting : PoseLookup::kFound;
  }
  if (after == poses_.begin()) return PoseLookup::kTooOld;
  const TimedPose& before = *(after - 1);
  const Utime gap_us = after->utime - before.utime;
  if (before.segment != after->segment || gap_us > from_seconds(options_.most_gap_s)) return PoseLookup::kGap;
  if (before.coasting || after->coasting) return PoseLookup::kCoasting;
  const double s = to_seconds(utime - before.utime) / to_seconds(gap_us);
  found = {utime, before.segment, interpolate(before.T_O_B, after->T_O_B, s), false};
  return PoseLookup::kFound;
}

}  // namespace covey::mesh
