// SPDX-License-Identifier: BSD-3-Clause
// Real pictures of a room (7-Scenes: Shotton et al., CVPR 2013), with depth images and poses of the camera.

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/place/database.h"
#include "core/place/stereo_features.h"
#include "core/place/verification.h"
#include "core/place/vocabulary.h"
#include "tests/data.h"

namespace covey::place {
namespace {

// The data set gives the depth camera's; the colour camera of that Kinect has about 525, and the depth image is not registered to it.
constexpr double kDepthFocal = 585.0;
constexpr double kColourFocal = 525.0;

struct Frame {
  FrameFeatures features;
  BagOfWords bag;
  SE3 T_W_C;
};

SE3 read_pose(const std::filesystem::path& file) {
  std::ifstream stream(file);
  Eigen::Matrix4d T;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) stream >> T(row, column);
  }
  return SE3::from_matrix(T);
}

std::vector<Frame> read_frames(const std::filesystem::path& folder, int step) {
  const Vocabulary vocabulary =
      Vocabulary::load(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/place/vocabulary.bin");
  MountedCamera camera;
  camera.camera = {640, 480, kColourFocal, kColourFocal, 320.0, 240.0, {}};
  std::vector<Frame> frames;
  for (int number = 0; number < 1000; number += step) {
    const auto name = folder / fmt::format("frame-{:06}", number);
    const cv::Mat image = cv::imread(name.string() + ".color.jpg", cv::IMREAD_GRAYSCALE);
    cv::Mat depth = cv::imread(name.string() + ".depth.png", cv::IMREAD_UNCHANGED);
    REQUIRE(!image.empty());
    depth.setTo(0, depth == 65535);
    depth.convertTo(depth, CV_32F, 1e-3);
    const double zoom = kColourFocal / kDepthFocal;
    const cv::Mat zoomed =
        (cv::Mat_<double>(2, 3) << zoom, 0, 320.0 * (1.0 - zoom), 0, zoom, 240.0 * (1.0 - zoom));
    cv::warpAffine(depth, depth, zoomed, depth.size(), cv::INTER_NEAREST);
    Frame frame{features_with_depth(image, depth, camera), {}, read_pose(name.string() + ".pose.txt")};
    frame.bag = vocabulary.bag(frame.features.descriptors);
    frames.push_back(std::move(frame));
  }
  return frames;
}

TEST_CASE("closures of a real room are right") {
  const auto folder = test_data("rgbd/seven_scenes");
  if (!folder) return;
  const auto frames = read_frames(*folder, 10);
  constexpr int kApart = 8;
  PlaceDatabase database;
  int tried = 0;
  int accepted = 0;
  double worst_m = 0.0;
  double worst_rad = 0.0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    int candidates = 2;
    for (const auto& hit : database.query(frames[k].bag, 0.0)) {
      if (static_cast<int>(k) - hit.entry < kApart) continue;
      if (candidates-- == 0) break;
      const Frame& other = frames[static_cast<std::size_t>(hit.entry)];
      const Verification result = verify(other.features, frames[k].features);
      ++tried;
      if (result.refused) continue;
      ++accepted;
      const Vector6d error = (result.T_A_B.inverse() * other.T_W_C.inverse() * frames[k].T_W_C).log();
      worst_m = std::max(worst_m, error.head<3>().norm());
      worst_rad = std::max(worst_rad, error.tail<3>().norm());
    }
    database.add(frames[k].bag);
  }
  std::cout << "7-Scenes: " << accepted << " of " << tried << " closures accepted, worst " << worst_m
            << " m and " << worst_rad << " rad off\n";
  REQUIRE(accepted > 40);
  REQUIRE(worst_m < 0.12);
  REQUIRE(worst_rad < 0.087);  // the colour camera's lens is not known
}

}  // namespace
}  // namespace covey::place
