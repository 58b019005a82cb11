// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Points from one picture to another by pyramidal Lucas-Kanade (Bouguet, "Pyramidal implementation of the Lucas Kanade feature tracker", 2001), with a
// start for each and two checks: what does not return to where it began was not the same point, and what does not look alike was not one at all (noise returns half of the time).

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace covey {

struct FlowOptions {
  int window_px = 11;  // odd
  int levels = 4;      // of the pyramid, the full picture included
  int iterations = 20;
  double epsilon_px = 0.01;  // an iteration that moves less is the last
  double return_px = 0.5;    // farthest from where it began
  double alike = 0.5;        // least correlation of the two windows
};

// The picture and its gradients, level by level, as OpenCV wants them.
struct ImagePyramid {
  std::vector<cv::Mat> levels;  // 2 l: picture, 2 l + 1: gradients
  const cv::Mat& picture(int level) const { return levels[2 * static_cast<std::size_t>(level)]; }
  bool empty() const { return levels.empty(); }
};

ImagePyramid build_pyramid(const cv::Mat& image, const FlowOptions& options);

// Where `points` of `from` are in `to`; nothing where that was not found. `levels` <= those of the pyramids: fewer where the start is good.
std::vector<std::optional<cv::Point2f>> track_points(const ImagePyramid& from, const ImagePyramid& to,
                                                     const std::vector<cv::Point2f>& points,
                                                     const std::vector<cv::Point2f>& start, int levels,
                                                     const FlowOptions& options);

}  // namespace covey
