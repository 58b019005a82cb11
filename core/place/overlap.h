// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a pose between two cameras foretells, against what they saw: of the best points of one, those that stand in the other's picture
// should be found there, at their place and with their descriptor. Where two places only share a thing (houses of one type), the thing's
// points agree and all that surrounds it does not. What is seen from another side, or from much nearer, looks different and need not be
// found.
//
// Of a camera of which only the best points are known nothing can be said to be missing: then its points are looked for in the other's
// picture, and not the other way round.

#include "core/place/features.h"

namespace covey::place {

struct Overlap {
  int foretold = 0;  // points of one camera that stand in the picture of the other and look alike there
  int found = 0;     // of those, with a point of a like descriptor there

  double share() const { return foretold > 0 ? static_cast<double>(found) / foretold : 0.0; }
};

// `direction`: how far off a view may be, on the plane z = 1; `bits`: a descriptor.
Overlap overlap_of(const FrameFeatures& c, const FrameFeatures& d, const SE3& T_C_D, double direction,
                   int bits);

}  // namespace covey::place
