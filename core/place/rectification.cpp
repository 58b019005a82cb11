// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/rectification.h"

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"

namespace covey::place {
namespace {

// Columns: R's axes in the left camera.
SO3 rectified_axes(const SE3& T_L_R) {
  const Eigen::Vector3d x = T_L_R.translation.normalized();
  const Eigen::Vector3d forward = Eigen::Vector3d::UnitZ() + T_L_R.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = forward.cross(x).normalized();
  Eigen::Matrix3d axes;
  axes << x, y, x.cross(y);
  return SO3::from_matrix(axes);
}

}  // namespace

Rectification::Rectification(const MountedCamera& left, const MountedCamera& right)
    : focal_px_(left.camera.fx), size_(left.camera.width, left.camera.height) {
  const SE3 T_L_R = left.T_B_C.inverse() * right.T_B_C;
  baseline_m_ = T_L_R.translation.norm();
  COVEY_CHECK(baseline_m_ > 0.0);
  R_C_R_ = rectified_axes(T_L_R);
  left_map_ = make_map(left.camera, R_C_R_);
  right_map_ = make_map(right.camera, T_L_R.rotation.inverse() * R_C_R_);
  constexpr int kMarginPx = 20;
  const cv::Mat white(left.camera.height, left.camera.width, CV_8U, cv::Scalar(255));
  cv::erode(this->left(white) == 255, left_mask_,
            cv::getStructuringElement(cv::MORPH_RECT, {2 * kMarginPx + 1, 2 * kMarginPx + 1}));
}

Eigen::Vector3d Rectification::ray(const cv::Point2f& pixel) const {
  return R_C_R_ * Eigen::Vector3d((pixel.x - 0.5 * (size_.width - 1)) / focal_px_,
                                  (pixel.y - 0.5 * (size_.height - 1)) / focal_px_, 1.0);
}

// Where each rectified pixel is found in the camera's picture.
BilinearMap Rectification::make_map(const PinholeCamera& camera, const SO3& R_C_R) const {
  constexpr float kNowhere = -100.0F;
  cv::Mat u(size_, CV_32F);
  cv::Mat v(size_, CV_32F);
  for (int row = 0; row < size_.height; ++row) {
    for (int column = 0; column < size_.width; ++column) {
      const Eigen::Vector3d ray_C =
          R_C_R * Eigen::Vector3d((column - 0.5 * (size_.width - 1)) / focal_px_,
                                  (row - 0.5 * (size_.height - 1)) / focal_px_, 1.0);
      const auto pixel = camera.project(ray_C);
      const bool seen = pixel && camera.contains(*pixel);
      u.at<float>(row, column) = seen ? static_cast<float>(pixel->x()) : kNowhere;
      v.at<float>(row, column) = seen ? static_cast<float>(pixel->y()) : kNowhere;
    }
  }
  return {u, v, {camera.width, camera.height}};
}

}  // namespace covey::place
