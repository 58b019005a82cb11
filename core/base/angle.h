// SPDX-License-Identifier: BSD-3-Clause
// Angles are radians; options that people write are degrees, and say so in their names: options.sigma_deg * kDegree.
#pragma once

#include <numbers>

namespace covey {

inline constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace covey
