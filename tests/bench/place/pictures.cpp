// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/pictures.h"

#include <algorithm>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "core/base/error.h"
#include "procs/lcd/images.h"

namespace covey::bench {
namespace {

constexpr double kStepM = 0.5;
constexpr double kStepRad = 15.0 * std::numbers::pi / 180.0;

// Whole when it has its name: an interrupted run leaves no half of a picture.
void keep(const std::filesystem::path& file, const cv::Mat& picture) {
  const std::filesystem::path partial = file.parent_path() / ("partial_" + file.filename().string());
  if (!cv::imwrite(partial, picture, {cv::IMWRITE_PNG_COMPRESSION, 1}))
    throw_input_error("{}: cannot be written", partial.string());
  std::filesystem::rename(partial, file);
}

}  // namespace

std::vector<View> cut_keyframes(const sim::Scenario& scenario) {
  std::vector<View> views;
  for (int robot = 0; robot < scenario.robots; ++robot) {
    const sim::Motion motion = scenario.ride(robot).motion;
    constexpr Utime kFrameUs = kUsPerSecond / sim::kStereoHz;
    int id = 0;
    View last;
    for (Utime utime = motion.begin; utime <= motion.end; utime += kFrameUs) {
      const SE3 T_W_B = motion.at(utime).T_W_B;
      const SE3 step = last.T_W_B.inverse() * T_W_B;
      if (id > 0 && step.translation.norm() < kStepM && step.rotation.log().norm() < kStepRad &&
          utime - last.utime < kUsPerSecond) {
        continue;
      }
      last = {{robot, motion.begin, id++}, utime, T_W_B};
      views.push_back(last);
    }
  }
  std::stable_sort(views.begin(), views.end(),
                   [](const View& a, const View& b) { return a.utime < b.utime; });
  return views;
}

Pictures::Pictures(std::filesystem::path folder, const sim::MeshWorld& world, const Rig& rig,
                   std::uint64_t seed)
    : folder_(std::move(folder)), world_(world), rig_(rig), seed_(seed) {}

std::pair<cv::Mat, cv::Mat> Pictures::take(const View& view) {
  if (folder_.empty()) return render(view);
  const auto folder = folder_ / ("robot" + std::to_string(view.name.robot));
  const auto left = folder / (std::to_string(view.utime) + "_left.png");
  const auto right = folder / (std::to_string(view.utime) + "_right.png");
  if (!std::filesystem::exists(left) || !std::filesystem::exists(right)) {
    const auto [left_picture, right_picture] = render(view);
    std::filesystem::create_directories(folder);
    keep(left, left_picture);
    keep(right, right_picture);
  }
  return {cv::imread(left, cv::IMREAD_GRAYSCALE), cv::imread(right, cv::IMREAD_GRAYSCALE)};
}

std::pair<cv::Mat, cv::Mat> Pictures::render(const View& view) {
  if (!cameras_) {
    sim::CameraOptions options;
    options.seed = seed_;
    cameras_ = std::make_unique<sim::SensorCameras>(world_, rig_, options);
  }
  const stereo_t stereo = cameras_->stereo(view.T_W_B, view.utime);
  const auto pair = images_of(stereo);
  COVEY_CHECK(pair.has_value());
  return {pair->left.clone(), pair->right.clone()};
}

}  // namespace covey::bench
