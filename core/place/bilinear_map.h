// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Draws a grey picture anew from where each of its pixels is in another one: between four pixels there, to a 32nd of a pixel. For one map
// and many pictures: the same values as cv::remap's in two thirds of its time.

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace covey::place {

class BilinearMap {
 public:
  BilinearMap() = default;
  // u, v (CV_32F, of the new picture's size): columns and rows of a picture of `from`'s size; what is not between four of its pixels is black.
  BilinearMap(const cv::Mat& u, const cv::Mat& v, cv::Size from);

  // CV_8U of `from`'s size (COVEY_CHECK).
  cv::Mat apply(const cv::Mat& image) const;

 private:
  // Neighbours in a row whose places lie close together, as in the other picture's row or nearly so.
  struct Span {
    int row = 0;
    int column = 0;
    int length = 0;
    int x = 0;  // 32nds of a pixel in the other picture, of the first
    int y = 0;
  };
  // From one to the next, less a whole pixel to the right: two bytes a pixel, since memory is what this waits for.
  struct Step {
    std::int8_t x = 0;
    std::int8_t y = 0;
  };
  cv::Size from_;
  cv::Size to_;
  std::vector<Span> spans_;
  std::vector<Step> steps_;  // one for each pixel of each span; the last of a span is not used
};

}  // namespace covey::place
