// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Points of the left picture in the right one. A point at m_l with inverse depth r is seen on the right at pi(R m_l~ + r t), T_right_left = (R, t): the right
// picture is searched along that curve (the lens bends it) where no inverse depth is known yet, by normalised cross-correlation at half resolution, and the
// best place is refined to a part of a pixel by Lucas-Kanade. A match is accepted where
//   - its way back ends where it began, and the patches still look alike,
//   - it lies on the epipolar line after undistortion,
//   - its inverse depth is possible: not behind infinity, not nearer than `nearest_m`,
//   - during a search nothing else on the curve looked nearly as good.

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/geometry/rig.h"
#include "core/vision/optical_flow.h"

namespace covey {

struct StereoOptions {
  double nearest_m = 0.3;
  double epipolar_px = 1.5;      // farthest from the epipolar line
  double infinity_px = 1.0;      // farthest behind infinity
  double min_correlation = 0.8;  // of 9x9 patches at half resolution
  double min_margin = 0.05;      // of the correlation, over the second best place
  int refine_levels = 2;
};

struct StereoQuery {
  cv::Point2f pixel;
  Eigen::Vector2d m;                    // the same, undistorted on z = 1
  std::optional<double> inverse_depth;  // where one is known
};

struct StereoMatch {
  Eigen::Vector2d m;           // undistorted, on z = 1 of the right camera
  double inverse_depth = 0.0;  // 1 / m, in the left camera; may be a little negative far away
};

class StereoMatcher {
 public:
  StereoMatcher(const MountedCamera& left, const MountedCamera& right, const StereoOptions& options);

  // One for each query; the pyramids have at least refine_levels (and two) levels.
  std::vector<std::optional<StereoMatch>> match(const ImagePyramid& left, const ImagePyramid& right,
                                                const std::vector<StereoQuery>& queries,
                                                const FlowOptions& flow) const;
  double baseline_m() const { return T_right_left_.translation.norm(); }

 private:
  std::optional<cv::Point2f> expect(const Eigen::Vector2d& m, double inverse_depth) const;
  std::optional<cv::Point2f> search(const ImagePyramid& left, const ImagePyramid& right,
                                    const StereoQuery& query) const;
  std::optional<StereoMatch> accept(const ImagePyramid& left, const ImagePyramid& right,
                                    const StereoQuery& query, const cv::Point2f& found) const;

  PinholeCamera right_;
  SE3 T_right_left_;
  StereoOptions options_;
};

}  // namespace covey
