// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/stereo_features.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/base/error.h"

namespace covey::place {
namespace {

const MountedCamera& right_camera(const Rig& rig) {
  COVEY_CHECK(rig.right.has_value());
  return *rig.right;
}

RowMatchOptions within_depths(RowMatchOptions rows, const Rectification& rectification, double near_m,
                              double far_m) {
  const double scale = rectification.focal_px() * rectification.baseline_m();
  rows.most_px = scale / near_m;
  rows.least_px = scale / far_m;
  return rows;
}

}  // namespace

StereoFeatures::StereoFeatures(const Rig& rig, const StereoFeatureOptions& options)
    : options_(options), T_B_C_(rig.left.T_B_C), rectification_(rig.left, right_camera(rig)) {
  options_.rows = within_depths(options.rows, rectification_, options.near_m, options.far_m);
}

FrameFeatures StereoFeatures::extract(const cv::Mat& left, const cv::Mat& right) const {
  const cv::Mat left_R = rectification_.left(left);
  const cv::Mat right_R = rectification_.right(right);
  OrbFeatures orb = detect_orb(left_R, options_.orb, rectification_.left_mask());
  const std::vector<float> disparities = match_rows(left_R, right_R, orb.pixels, options_.rows);
  FrameFeatures features;
  features.T_B_C = T_B_C_;
  const double scale = rectification_.focal_px() * rectification_.baseline_m();
  features.noise = {options_.view_px / rectification_.focal_px(), options_.disparity_px / scale};
  for (std::size_t k = 0; k < orb.pixels.size(); ++k) {
    const Eigen::Vector3d ray_C = rectification_.ray(orb.pixels[k]);
    const double depth_m = disparities[k] > 0.0F ? scale / disparities[k] * ray_C.z() : 0.0;
    features.bearings_C.emplace_back(ray_C.normalized().cast<float>());
    features.depths_m.push_back(static_cast<float>(depth_m));
  }
  features.descriptors = std::move(orb.descriptors);
  return features;
}

FrameFeatures features_with_depth(const cv::Mat& image, const cv::Mat& depth_m, const MountedCamera& camera,
                                  const OrbOptions& options) {
  const OrbFeatures orb = detect_orb(image, options);
  FrameFeatures features;
  features.T_B_C = camera.T_B_C;
  for (std::size_t k = 0; k < orb.pixels.size(); ++k) {
    const cv::Point2f& pixel = orb.pixels[k];
    const auto direction = camera.camera.undistort({pixel.x, pixel.y});
    if (!direction) continue;
    const float depth =
        depth_m.at<float>(static_cast<int>(std::lround(pixel.y)), static_cast<int>(std::lround(pixel.x)));
    features.bearings_C.emplace_back(direction->homogeneous().normalized().cast<float>());
    features.depths_m.push_back(depth > 0.0F ? depth : 0.0F);
    features.descriptors.push_back(orb.descriptors[k]);
  }
  return features;
}

}  // namespace covey::place
