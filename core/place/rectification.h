// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Both cameras of a rig turned to look the same way, across their baseline, without distortion and with equal intrinsics: a point
// is then on the same row of both pictures, and
//
//   depth = focal * baseline / disparity,   disparity = u_left - u_right.
//
// R is the left camera's frame so turned; the right one differs by the baseline along x.

#include <opencv2/core.hpp>

#include "core/geometry/rig.h"
#include "core/place/bilinear_map.h"

namespace covey::place {

class Rectification {
 public:
  Rectification(const MountedCamera& left, const MountedCamera& right);

  cv::Mat left(const cv::Mat& image) const { return left_map_.apply(image); }
  cv::Mat right(const cv::Mat& image) const { return right_map_.apply(image); }

  // Not 0 where the left picture has something and its edge is not near: an edge of the picture is no feature of the world.
  const cv::Mat& left_mask() const { return left_mask_; }

  cv::Size size() const { return size_; }
  double focal_px() const { return focal_px_; }
  double baseline_m() const { return baseline_m_; }
  // In the left camera C, of length 1 along R's z axis.
  Eigen::Vector3d ray(const cv::Point2f& pixel) const;

 private:
  BilinearMap make_map(const PinholeCamera& camera, const SO3& R_C_R) const;

  double focal_px_ = 1.0;
  double baseline_m_ = 0.0;
  cv::Size size_;
  SO3 R_C_R_;
  BilinearMap left_map_;
  BilinearMap right_map_;
  cv::Mat left_mask_;
};

}  // namespace covey::place
