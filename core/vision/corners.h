// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// New corners where a frame has too few: the picture is cut into cells, and each cell that holds fewer tracks than its share is filled up with the points
// of the largest smaller eigenvalue of the gradients' second-moment matrix (Shi and Tomasi, "Good features to track", CVPR 1994) that keep
// their distance from what is there. Only cells that want something are looked at, so a frame in which few tracks died costs little.

#include <opencv2/core.hpp>
#include <vector>

namespace covey {

struct CornerOptions {
  int columns = 10;  // of cells
  int rows = 6;
  int per_cell = 3;             // tracks that a cell wants
  double min_distance_px = 15;  // between corners
  double min_response = 1e-4;   // smaller eigenvalue, of gradients per pixel with grey values from 0 to 1
  int border_px = 10;
  int most = 60;  // new corners per frame: the strongest
};

// Strongest first.
std::vector<cv::Point2f> detect_corners(const cv::Mat& image, const std::vector<cv::Point2f>& present,
                                        const CornerOptions& options);

}  // namespace covey
