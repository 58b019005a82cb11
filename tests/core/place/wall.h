// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A textured wall as a camera with its lens sees it, for tests with pictures.

#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "core/geometry/rig.h"

namespace covey::place::testing {

// Grey noise of a few pixels' grain.
inline cv::Mat make_texture(int width, int height, std::uint64_t seed) {
  cv::Mat noise(height, width, CV_8U);
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {0, 0}, 2.0);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  return noise;
}

// The points p with normal^T p = distance; the texture is glued on along x and y.
struct Wall {
  Eigen::Vector3d normal_W;
  double distance_m;
  cv::Mat texture;
  double px_per_m = 110.0;
};

inline cv::Mat take_picture(const Wall& wall, const PinholeCamera& camera, const SE3& T_W_C) {
  cv::Mat u(camera.height, camera.width, CV_32F, cv::Scalar(-1e6));
  cv::Mat v = u.clone();
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const auto m = camera.undistort({static_cast<double>(column), static_cast<double>(row)});
      if (!m) continue;
      const Eigen::Vector3d ray_C = m->homogeneous();
      const double t = (wall.distance_m - wall.normal_W.dot(T_W_C.translation)) /
                       wall.normal_W.dot(T_W_C.rotation * ray_C);
      const Eigen::Vector3d p_W = T_W_C * Eigen::Vector3d(t * ray_C);
      u.at<float>(row, column) = static_cast<float>(0.5 * wall.texture.cols + wall.px_per_m * p_W.x());
      v.at<float>(row, column) = static_cast<float>(0.5 * wall.texture.rows + wall.px_per_m * p_W.y());
    }
  }
  cv::Mat picture;
  cv::remap(wall.texture, picture, u, v, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return picture;
}

}  // namespace covey::place::testing
