// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/seven_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/base/error.h"

namespace covey::bench {
namespace {

constexpr double kDepthFocal = 585.0;  // px
constexpr double kColourFocal = 525.0;
constexpr Utime kFrameUs = kUsPerSecond / 30;
constexpr int kFrames = 1000;  // of a sequence, some of which are there
constexpr std::uint16_t kNoDepth = 65535;

std::string path_of(const std::filesystem::path& folder, int number) {
  return (folder / fmt::format("frame-{:06}", number)).string();
}

SE3 read_pose(const std::string& file) {
  std::ifstream stream(file);
  Eigen::Matrix4d T;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) stream >> T(row, column);
  }
  if (!stream) throw_input_error("{}: not a pose; expected four rows of four numbers", file);
  return SE3::from_matrix(T);
}

}  // namespace

MountedCamera scene_camera() {
  MountedCamera camera;
  camera.camera = {640, 480, kColourFocal, kColourFocal, 320.0, 240.0, {}};
  return camera;
}

// A view's segment is the number of its robot's first frame, so that its file follows from its name and time.
std::vector<View> scene_views(const std::filesystem::path& folder) {
  std::vector<int> numbers;
  for (int number = 0; number < kFrames; ++number) {
    if (std::filesystem::exists(path_of(folder, number) + ".pose.txt")) numbers.push_back(number);
  }
  if (numbers.size() < 2)
    throw_input_error("{}: no frames of 7-Scenes; expected frame-000000.pose.txt and so on", folder.string());
  std::vector<View> views;
  const std::size_t half = numbers.size() / 2;
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const int robot = k < half ? 0 : 1;
    const int first = numbers[robot == 0 ? 0 : half];
    const int id = static_cast<int>(robot == 0 ? k : k - half);
    views.push_back({{robot, first, id},
                     (numbers[k] - first) * kFrameUs,
                     read_pose(path_of(folder, numbers[k]) + ".pose.txt")});
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const View& a, const View& b) { return a.utime < b.utime; });
  return views;
}

SceneFrame read_scene_frame(const std::filesystem::path& folder, const View& view) {
  const std::string path = path_of(folder, static_cast<int>(view.name.segment + view.utime / kFrameUs));
  SceneFrame frame{cv::imread(path + ".color.jpg", cv::IMREAD_GRAYSCALE),
                   cv::imread(path + ".depth.png", cv::IMREAD_UNCHANGED)};
  if (frame.image.empty() || frame.depth_m.empty())
    throw_input_error("{}.color.jpg and .depth.png: cannot be read", path);
  frame.depth_m.setTo(0, frame.depth_m == kNoDepth);
  frame.depth_m.convertTo(frame.depth_m, CV_32F, 1e-3);
  constexpr double kZoom = kColourFocal / kDepthFocal;
  const cv::Mat zoomed =
      (cv::Mat_<double>(2, 3) << kZoom, 0, 320.0 * (1.0 - kZoom), 0, kZoom, 240.0 * (1.0 - kZoom));
  cv::warpAffine(frame.depth_m, frame.depth_m, zoomed, frame.depth_m.size(), cv::INTER_NEAREST);
  return frame;
}

}  // namespace covey::bench
