// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What odometry would say where the poses are given: a STATE per pose, and keyframes every 0.5 m, 15 degrees or second. Frame O is that of
// the given poses. The covariances are those of a good tracker (1 cm and 0.2 degrees from one pose to the next), not measured ones.

#include <covey/keyframe_t.hpp>
#include <covey/state_t.hpp>
#include <optional>

#include "core/base/time.h"
#include "core/geometry/se3.h"

namespace covey {

class GivenOdometry {
 public:
  explicit GivenOdometry(int robot) : robot_(robot) {}

  struct Said {
    state_t state;
    std::optional<keyframe_t> keyframe;
  };
  // In the order of time; the first pose names the segment.
  Said add(Utime utime, const SE3& T_O_B);

 private:
  int robot_;
  std::int64_t segment_ = 0;
  std::int32_t next_id_ = 0;
  Utime last_utime_ = 0;
  SE3 last_T_O_B_;
  Utime keyframe_utime_ = 0;
  SE3 T_O_K_;
};

}  // namespace covey
