// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the pixels round a corner say of it. Both need kPatchMargin pixels on every side of (x, y), which they do not check.

#include <opencv2/core.hpp>

namespace covey::place {

constexpr int kPatchMargin = 16;

// How much of a corner it is: Harris and Stephens, "A combined corner and edge detector", 1988, over a window W of 7 x 7,
//
//   det M - 0.04 tr(M)^2,   M = sum over W of [Ix^2, Ix Iy; Ix Iy, Iy^2],
//
// with I of 0 to 1 and its derivatives by Sobel's 3 x 3 weights over 4, M over the window's side.
float corner_strength(const cv::Mat& image, int x, int y);

// Where its light is: the direction of the intensities' centroid in a disc of 15 pixels (ORB: Rublee et al., ICCV 2011), degrees from x to y.
float orientation_deg(const cv::Mat& image, int x, int y);

}  // namespace covey::place
