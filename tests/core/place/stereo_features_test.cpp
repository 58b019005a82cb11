// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/stereo_features.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/geometry/rig.h"
#include "tests/core/place/wall.h"

namespace covey::place {
namespace {

using testing::make_texture;

TEST_CASE("a shift of rows is found to a tenth of a pixel") {
  const cv::Mat left = make_texture(400, 200, 1);
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
        std::pair{make_texture(400, 200, 1), make_texture(400, 200, 2)}}) {
    for (const float disparity : match_rows(left, right, points)) REQUIRE(disparity == 0.0F);
  }
  REQUIRE(match_rows(stripes, stripes, {{0, 0}, {399, 199}, {3, 100}}) == std::vector<float>{0, 0, 0});
}

// A textured wall that fills the view, through the rigs' real lenses.
TEST_CASE("points of a wall come back at their place through each rig's lenses") {
  for (const char* file : {"configs/sensors/euroc.yaml", "configs/sensors/rover.yaml"}) {
    const Rig rig = read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / file);
    const SE3 T_L_R = rig.left.T_B_C.inverse() * rig.right->T_B_C;
    const testing::Wall wall{Eigen::Vector3d(0.2, -0.1, 1.0).normalized(), 4.0, make_texture(1600, 1200, 3)};
    const FrameFeatures features = StereoFeatures(rig).extract(take_picture(wall, rig.left.camera, SE3{}),
                                                               take_picture(wall, rig.right->camera, T_L_R));
    REQUIRE(features.size() == 500);
    const double focal = rig.left.camera.fx;
    REQUIRE(features.noise.direction == Approx(1.5 / focal));
    REQUIRE(features.noise.inverse_depth == Approx(0.5 / (focal * T_L_R.translation.norm())));
    int with_depth = 0;
    int good = 0;
    for (std::size_t k = 0; k < features.size(); ++k) {
      REQUIRE(features.bearings_C[k].norm() == Approx(1.0F));
      if (!features.has_depth(k)) continue;
      ++with_depth;
      // px of disparity, at focal * baseline of at least 50
      const double off_m = std::abs(wall.normal_W.dot(features.point(k)) - wall.distance_m);
      good += off_m < 0.12 ? 1 : 0;
    }
    REQUIRE(with_depth > 350);
    REQUIRE(good > with_depth * 95 / 100);
  }
}

TEST_CASE("features are spread, as many as asked, and the same twice") {
  cv::Mat image = make_texture(752, 480, 4);
  image.colRange(0, 500) = 0.3 * image.colRange(0, 500);  // weak on most of the picture
  const OrbFeatures features = detect_orb(image);
  REQUIRE(features.pixels.size() == 500);
  REQUIRE(features.descriptors.size() == 500);
  int weak_side = 0;
  for (const auto& pixel : features.pixels) weak_side += pixel.x < 500 ? 1 : 0;
  REQUIRE(weak_side > 50);  // the 500 strongest are all on the other side but for 12
  REQUIRE(detect_orb(image).descriptors == features.descriptors);
  // The first so many are spread too.
  int weak_of_first = 0;
  for (int k = 0; k < 150; ++k) weak_of_first += features.pixels[static_cast<std::size_t>(k)].x < 500 ? 1 : 0;
  REQUIRE(weak_of_first > 50);
  REQUIRE(detect_orb(cv::Mat(480, 752, CV_8U, cv::Scalar(7))).pixels.empty());
}

}  // namespace
}  // namespace covey::place
