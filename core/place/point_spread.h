// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How the points that agree with a pose lie. Where they fill one corner of a picture, one line or one plane, something small and repeated
// may have agreed (a window, a kerb, the front of a house of a type), whatever the covariance says.

#include <utility>
#include <vector>

#include "core/place/features.h"

namespace covey::place {

struct PointSpread {
  // Standard deviations of the directions on the plane z = 1 along the shorter and the longer axis of their cloud, in the picture where
  // the shorter is less.
  double across = 0.0;
  double along = 0.0;
  // Of the points with a depth off the plane that fits them best, over their mean distance; 0 where there are fewer than three.
  double thickness = 0.0;
};

// `pairs`: index in c, index in d.
PointSpread spread_of(const FrameFeatures& c, const FrameFeatures& d,
                      const std::vector<std::pair<int, int>>& pairs, const SE3& T_C_D);

}  // namespace covey::place
