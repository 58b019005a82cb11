// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The two RANSACs of verification: which pairs of points (index in c, index in d) agree with one camera motion.

#include <utility>
#include <vector>

#include "core/place/features.h"

namespace covey::place {

using Pairs = std::vector<std::pair<int, int>>;

struct PoseHypothesis {
  Pairs agreeing;
  SE3 T_C_D;
};

// Directions only, so that T_C_D is known but for the length of its translation. `direction`: how far an inlier's views may
// be off on the plane z = 1.
PoseHypothesis five_point_ransac(const FrameFeatures& c, const FrameFeatures& d, const Pairs& pairs,
                                 double direction, int iterations);

// Of those pairs with a depth in c: the pose of d in metres.
PoseHypothesis three_point_ransac(const FrameFeatures& c, const FrameFeatures& d, const Pairs& pairs,
                                  double direction, int iterations);

}  // namespace covey::place
