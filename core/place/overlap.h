// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a pose between two cameras foretells, against what they saw: a point of one that stands in the other's picture should be found
// there, at its place and with its descriptor. Where two places only share a thing (houses of one type), the thing's points agree and all
// that surrounds it does not.

#include "core/place/features.h"

namespace covey::place {

struct Overlap {
  int foretold = 0;  // points with depth of either camera that stand in the picture of the other
  int found = 0;     // of those, with a point of a like descriptor there

  double share() const { return foretold > 0 ? static_cast<double>(found) / foretold : 0.0; }
};

// `direction`: how far off a view may be, on the plane z = 1; `bits`: a descriptor.
Overlap overlap_of(const FrameFeatures& c, const FrameFeatures& d, const SE3& T_C_D, double direction,
                   int bits);

}  // namespace covey::place
