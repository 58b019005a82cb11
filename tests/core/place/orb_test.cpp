// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/orb.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <opencv2/features2d.hpp>

#include "core/place/patch_measures.h"
#include "tests/core/place/wall.h"

namespace covey::place {
namespace {

using testing::make_texture;

// OpenCV's, all that it finds: ten times as many as are kept.
std::map<std::pair<float, float>, std::vector<Descriptor>> all_of(const cv::Mat& image,
                                                                  const OrbOptions& options) {
  const auto orb = cv::ORB::create(10 * options.features, static_cast<float>(options.scale), options.levels,
                                   31, 0, 2, cv::ORB::HARRIS_SCORE, 31, options.fast_threshold);
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  orb->detectAndCompute(image, cv::noArray(), points, descriptors);
  std::map<std::pair<float, float>, std::vector<Descriptor>> all;
  for (std::size_t k = 0; k < points.size(); ++k)
    all[{points[k].pt.x, points[k].pt.y}].push_back(
        descriptor_from(descriptors.ptr<std::uint8_t>(static_cast<int>(k))));
  return all;
}

TEST_CASE("ORB features are OpenCV's, to the bit, at every scale") {
  const OrbOptions options;
  const cv::Mat image = make_texture(752, 480, 5);
  const auto all = all_of(image, options);
  const OrbFeatures features = detect_orb(image, options);
  REQUIRE(features.pixels.size() == 500);
  int fractional = 0;
  for (std::size_t k = 0; k < features.pixels.size(); ++k) {
    const cv::Point2f& pixel = features.pixels[k];
    const auto found = all.find({pixel.x, pixel.y});
    REQUIRE(found != all.end());
    REQUIRE(std::count(found->second.begin(), found->second.end(), features.descriptors[k]) > 0);
    fractional += pixel.x != std::floor(pixel.x) ? 1 : 0;
  }
  REQUIRE(fractional > 100);  // of the upper levels
}

TEST_CASE("ORB features keep out of what a mask hides, and a picture smaller than a descriptor has none") {
  const cv::Mat image = make_texture(752, 480, 6);
  cv::Mat mask(image.size(), CV_8U, cv::Scalar(0));
  mask(cv::Rect(300, 100, 200, 200)) = 255;
  const OrbFeatures features = detect_orb(image, {}, mask);
  REQUIRE(features.pixels.size() > 100);
  for (const cv::Point2f& pixel : features.pixels) {
    REQUIRE(std::abs(pixel.x - 399.5F) <= 100.5F);
    REQUIRE(std::abs(pixel.y - 199.5F) <= 100.5F);
  }
  REQUIRE(detect_orb(make_texture(60, 480, 6)).pixels.empty());
  REQUIRE(detect_orb(make_texture(90, 90, 6)).pixels.size() > 5);
}

TEST_CASE("a patch's strength is Harris and Stephens', its direction that of its light") {
  const cv::Mat image = make_texture(80, 60, 7);
  const auto at = [&image](int x, int y) { return static_cast<double>(image.at<std::uint8_t>(y, x)); };
  for (int x = kPatchMargin; x < 80 - kPatchMargin; x += 5) {
    for (int y = kPatchMargin; y < 60 - kPatchMargin; y += 3) {
      double xx = 0.0;
      double xy = 0.0;
      double yy = 0.0;
      for (int v = y - 3; v <= y + 3; ++v) {
        for (int u = x - 3; u <= x + 3; ++u) {
          double dx = 0.0;
          double dy = 0.0;
          for (const int k : {-1, 0, 1}) {
            const double weight = (k == 0 ? 2.0 : 1.0) / (4.0 * 7.0 * 255.0);
            dx += weight * (at(u + 1, v + k) - at(u - 1, v + k));
            dy += weight * (at(u + k, v + 1) - at(u + k, v - 1));
          }
          xx += dx * dx;
          xy += dx * dy;
          yy += dy * dy;
        }
      }
      const double expected = xx * yy - xy * xy - 0.04 * (xx + yy) * (xx + yy);
      REQUIRE(corner_strength(image, x, y) == Approx(expected).epsilon(1e-3).margin(1e-12));
    }
  }
  // A light beside the middle, all round.
  for (double deg = 5.0; deg < 360.0; deg += 25.0) {
    cv::Mat dark(60, 80, CV_8U, cv::Scalar(0));
    const double angle = deg * CV_PI / 180.0;
    const cv::Point light(cvRound(40 + 10 * std::cos(angle)), cvRound(30 + 10 * std::sin(angle)));
    dark.at<std::uint8_t>(light) = 255;
    const double expected = std::atan2(light.y - 30, light.x - 40) * 180.0 / CV_PI;
    REQUIRE(std::cos((orientation_deg(dark, 40, 30) - expected) * CV_PI / 180.0) > 0.9999);
  }
}

}  // namespace
}  // namespace covey::place
