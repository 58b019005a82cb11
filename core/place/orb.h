// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// ORB features spread over an image: far more corners are detected than wanted, and each cell of a grid keeps its strongest, so
// that one textured wall does not take them all. The best stand first, so that the first so many are a choice by strength and spread too.

#include <opencv2/core.hpp>
#include <vector>

#include "core/place/descriptor.h"

namespace covey::place {

struct OrbOptions {
  int features = 500;
  int columns = 10;
  int rows = 6;
  double scale = 1.2;  // from one level of the pyramid to the next
  int levels = 8;
  int fast_threshold = 15;
};

struct OrbFeatures {
  std::vector<cv::Point2f> pixels;  // in the full image, (0, 0) = centre of the top left pixel
  std::vector<Descriptor> descriptors;
};

// Of a grey image, where the mask (CV_8U; empty: everywhere) is not 0; deterministic.
OrbFeatures detect_orb(const cv::Mat& image, const OrbOptions& options = {}, const cv::Mat& mask = {});

}  // namespace covey::place
