// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The disparities of single points of a rectified pair: the patch round a point of the left image is slid along the same row of the
// right one; the least sum of absolute differences wins if it is small, clearly less than any other that is not beside it, and
// found again from right to left. The fraction of a pixel comes from two straight flanks through the minimum and its neighbours.

#include <opencv2/core.hpp>
#include <vector>

namespace covey::place {

struct RowMatchOptions {
  double least_px = 1.0;
  double most_px = 128.0;
  double most_difference = 14.0;  // mean over the patch, grey levels
  double uniqueness = 0.85;       // of the second best
};

// 0: none.
std::vector<float> match_rows(const cv::Mat& left, const cv::Mat& right,
                              const std::vector<cv::Point2f>& points, const RowMatchOptions& options = {});

}  // namespace covey::place
