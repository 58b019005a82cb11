// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The features of a stereo pair: ORB in the left image, depths from the right one, both rectified first.

#include <opencv2/core.hpp>

#include "core/place/features.h"
#include "core/place/orb.h"
#include "core/place/rectification.h"
#include "core/place/row_matcher.h"

namespace covey::place {

struct StereoFeatureOptions {
  OrbOptions orb;
  RowMatchOptions rows;
  double near_m = 0.5;
  double far_m = 40.0;
  double view_px = 1.5;  // standard deviations
  double disparity_px = 0.5;
};

class StereoFeatures {
 public:
  // The rig must have a right camera (COVEY_CHECK).
  explicit StereoFeatures(const Rig& rig, const StereoFeatureOptions& options = {});

  // Grey images of the size that the rig says.
  FrameFeatures extract(const cv::Mat& left, const cv::Mat& right) const;

  const Rectification& rectification() const { return rectification_; }

 private:
  StereoFeatureOptions options_;
  SE3 T_B_C_;
  Rectification rectification_;
};

// Of an image with a depth for each pixel (m along the optical axis, CV_32F, same size; 0: none), from a camera without right twin.
FrameFeatures features_with_depth(const cv::Mat& image, const cv::Mat& depth_m, const MountedCamera& camera,
                                  const OrbOptions& options = {});

}  // namespace covey::place
