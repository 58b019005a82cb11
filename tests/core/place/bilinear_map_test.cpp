// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/bilinear_map.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/core/place/wall.h"

namespace covey::place {
namespace {

struct Places {
  cv::Mat u;
  cv::Mat v;
};

// Turned, larger and bent, as a lens bends; from some columns on elsewhere, as no lens does.
Places bent(cv::Size size) {
  Places places{cv::Mat(size, CV_32F), cv::Mat(size, CV_32F)};
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double x = column - 0.5 * size.width;
      const double y = row - 0.5 * size.height;
      const double scale = 0.9 + 0.4 * (x * x + y * y) / (size.width * size.width);
      const double jump = column > 3 * size.width / 4 ? 40.0 : 0.0;
      places.u.at<float>(row, column) = static_cast<float>(0.5 * size.width + scale * (x - 0.1 * y) - jump);
      places.v.at<float>(row, column) = static_cast<float>(0.5 * size.height + scale * (y + 0.1 * x));
    }
  }
  return places;
}

TEST_CASE("a picture drawn anew is as OpenCV draws it, and black outside") {
  const cv::Mat image = testing::make_texture(320, 200, 3);
  const Places places = bent({300, 180});
  cv::Mat expected;
  cv::Mat first;
  cv::Mat second;
  cv::convertMaps(places.u, places.v, first, second, CV_16SC2);
  cv::remap(image, expected, first, second, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  const BilinearMap map(places.u, places.v, image.size());
  const cv::Mat drawn = map.apply(image);
  REQUIRE(drawn.size() == places.u.size());
  int inside = 0;
  for (int row = 0; row < drawn.rows; ++row) {
    for (int column = 0; column < drawn.cols; ++column) {
      const float u = places.u.at<float>(row, column);
      const float v = places.v.at<float>(row, column);
      const int value = drawn.at<std::uint8_t>(row, column);
      if (u > 0.1F && v > 0.1F && u < 318.9F && v < 198.9F) {
        ++inside;
        REQUIRE(value == expected.at<std::uint8_t>(row, column));
      } else if (u < -0.1F || v < -0.1F || u > 319.1F || v > 199.1F) {
        REQUIRE(value == 0);
      }
    }
  }
  REQUIRE(inside > drawn.rows * drawn.cols * 8 / 10);

  // Of a picture that is part of another.
  cv::Mat large(300, 400, CV_8U, cv::Scalar(77));
  cv::Mat part = large(cv::Rect(20, 30, 320, 200));
  image.copyTo(part);
  REQUIRE(cv::countNonZero(map.apply(part) != drawn) == 0);
}

}  // namespace
}  // namespace covey::place
