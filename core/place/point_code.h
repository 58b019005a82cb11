// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where a keyframe's points are, in as many bits as they are known to. A direction on the plane z = 1 and an inverse depth, whose errors
// do not depend on the distance, are rounded to a quarter of their standard deviation, which adds 1/192 to their variance. In units of
// that they are whole numbers, range-coded: x, y and inverse depth of point after point, 0 where the depth is not known.

#include <cstdint>
#include <vector>

#include "core/place/features.h"

namespace covey::place {

std::vector<std::uint8_t> encode_points(const FrameFeatures& features);

// `n` points into `features`, whose noise is set. Null, else what is wrong: "bearings", "depths", "code" (it does not end where it should).
const char* decode_points(const std::vector<std::uint8_t>& code, int n, FrameFeatures& features);

}  // namespace covey::place
