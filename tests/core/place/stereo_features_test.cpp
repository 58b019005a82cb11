// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/stereo_features.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/geometry/rig.h"
#include "tests/core/geometry/random.h"

namespace covey::place {
namespace {

// Grey noise of a few pixels' grain.
cv::Mat texture(int width, int height, std::uint64_t seed) {
  cv::Mat noise(height, width, CV_8U);
  cv::RNG random(seed);
  random.fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(noise, noise, {0, 0}, 2.0);
  cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
  return noise;
}

float grey_at(const cv::Mat& image, double u, double v) {
  cv::Mat sample;
  cv::getRectSubPix(image, {1, 1}, {static_cast<float>(u), static_cast<float>(v)}, sample);
  return sample.at<std::uint8_t>(0, 0);
}

TEST_CASE("a shift of rows is found to a tenth of a pixel") {
  const cv::Mat left = texture(400, 200, 1);
  for (const double shift : {5.0, 12.3, 20.5, 33.75}) {
    cv::Mat right;
    const cv::Mat move = (cv::Mat_<double>(2, 3) << 1.0, 0.0, -shift, 0.0, 1.0, 0.0);
    cv::warpAffine(left, right, move, left.size(), cv::INTER_CUBIC);
    std::vector<cv::Point2f> points;
    for (float x = 60; x < 380; x += 17) {
      for (float y = 10; y < 190; y += 13) points.emplace_back(x, y);
    }
    const auto disparities = match_rows(left, right, points);
    int found = 0;
    double squared = 0.0;
    for (const float disparity : disparities) {
      if (disparity == 0.0F) continue;
      ++found;
      REQUIRE(std::abs(disparity - shift) < 0.6);
      squared += std::pow(disparity - shift, 2);
    }
    REQUIRE(found > static_cast<int>(points.size()) * 8 / 10);
    REQUIRE(std::sqrt(squared / found) < 0.12);
  }
}

TEST_CASE("what repeats along the row, is flat or is not there has no disparity") {
  cv::Mat stripes(200, 400, CV_8U);
  for (int x = 0; x < stripes.cols; ++x) stripes.col(x) = 128 + 100 * std::sin(x * 0.5);
  const std::vector<cv::Point2f> points{{100, 50}, {200, 100}, {300, 150}};
  for (const auto& [left, right] :
       {std::pair{stripes, stripes},
        std::pair{cv::Mat(200, 400, CV_8U, cv::Scalar(90)), cv::Mat(200, 400, CV_8U, cv::Scalar(90))},
        std::pair{texture(400, 200, 1), texture(400, 200, 2)}}) {
    for (const float disparity : match_rows(left, right, points)) REQUIRE(disparity == 0.0F);
  }
  REQUIRE(match_rows(stripes, stripes, {{0, 0}, {399, 199}, {3, 100}}) == std::vector<float>{0, 0, 0});
}

// A textured wall that fills the view, through the rigs' real lenses.
TEST_CASE("points of a wall come back at their place through each rig's lenses") {
  for (const char* file : {"configs/sensors/euroc.yaml", "configs/sensors/rover.yaml"}) {
    const Rig rig = read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / file);
    const Eigen::Vector3d normal_L = Eigen::Vector3d(0.2, -0.1, 1.0).normalized();
    const double distance = 4.0;
    const cv::Mat wall = texture(1600, 1200, 3);
    const SE3 T_L_R = rig.left.T_B_C.inverse() * rig.right->T_B_C;
    const auto render = [&](const MountedCamera& mounted, const SE3& T_L_C) {
      cv::Mat image(mounted.camera.height, mounted.camera.width, CV_8U, cv::Scalar(0));
      for (int v = 0; v < image.rows; ++v) {
        for (int u = 0; u < image.cols; ++u) {
          const auto m = mounted.camera.undistort({static_cast<double>(u), static_cast<double>(v)});
          if (!m) continue;
          const Eigen::Vector3d ray_L = T_L_C.rotation * Eigen::Vector3d(m->homogeneous());
          const double t = (distance - normal_L.dot(T_L_C.translation)) / normal_L.dot(ray_L);
          const Eigen::Vector3d p_L = T_L_C * Eigen::Vector3d(t * m->homogeneous());
          image.at<std::uint8_t>(v, u) =
              static_cast<std::uint8_t>(grey_at(wall, 800.0 + 110.0 * p_L.x(), 600.0 + 110.0 * p_L.y()));
        }
      }
      return image;
    };
    const FrameFeatures features =
        StereoFeatures(rig).extract(render(rig.left, SE3{}), render(*rig.right, T_L_R));
    REQUIRE(features.size() == 500);
    int with_depth = 0;
    int good = 0;
    for (std::size_t k = 0; k < features.size(); ++k) {
      REQUIRE(features.bearings_C[k].norm() == Approx(1.0F));
      if (!features.has_depth(k)) continue;
      ++with_depth;
      // px of disparity, at focal * baseline of at least 50
      const double off_m = std::abs(normal_L.dot(features.point(k)) - distance);
      good += off_m < 0.12 ? 1 : 0;
    }
    REQUIRE(with_depth > 350);
    REQUIRE(good > with_depth * 95 / 100);
  }
}

TEST_CASE("features are spread, as many as asked, and the same twice") {
  cv::Mat image = texture(752, 480, 4);
  image.colRange(0, 500) = 0.3 * image.colRange(0, 500);  // weak on most of the picture
  const OrbFeatures features = detect_orb(image);
  REQUIRE(features.pixels.size() == 500);
  REQUIRE(features.descriptors.size() == 500);
  int weak_side = 0;
  for (const auto& pixel : features.pixels) weak_side += pixel.x < 500 ? 1 : 0;
  REQUIRE(weak_side > 50);  // the 500 strongest are all on the other side but for 12
  REQUIRE(detect_orb(image).descriptors == features.descriptors);
  REQUIRE(detect_orb(cv::Mat(480, 752, CV_8U, cv::Scalar(7))).pixels.empty());
}

}  // namespace
}  // namespace covey::place
