// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The poses of the last few seconds, at the rate of the IMU, and the one at the stamp of an image between them.

#include <cstdint>
#include <deque>

#include "core/base/time.h"
#include "core/geometry/se3.h"

namespace covey::mesh {

struct HistoryOptions {
  double length_s = 5.0;
  double most_gap_s = 0.1;  // between two poses that may be interpolated
};

struct TimedPose {
  Utime utime = 0;
  std::int64_t segment = 0;
  SE3 T_O_B;
  bool coasting = false;  // odometry without images: not to be mapped with
};

enum class PoseLookup { kFound, kNotYet, kTooOld, kGap, kCoasting };

class PoseHistory {
 public:
  explicit PoseHistory(const HistoryOptions& options = {}) : options_(options) {}

  // False, and without effect, where it is no newer than the newest of its segment; another segment may begin earlier, and then nothing
  // before it counts any more.
  bool add(const TimedPose& pose);
  // `found` is set with kFound.
  PoseLookup at(Utime utime, TimedPose& found) const;

 private:
  HistoryOptions options_;
  std::deque<TimedPose> poses_;
};

}  // namespace covey::mesh
