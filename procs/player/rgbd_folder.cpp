// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/rgbd_folder.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>
#include <string>

#include "core/base/error.h"

namespace covey {
namespace {

namespace fs = std::filesystem;

constexpr double kTumDepthPerM = 5000.0;
constexpr double kFrameDepthPerM = 1000.0;
constexpr Utime kColourWithinUs = 20'000;
constexpr Utime kPoseGapUs = 100'000;
constexpr Utime kFirstFrameUs = kUsPerSecond;
constexpr std::int64_t kFramesPerSecond = 30;
constexpr int kMostDepthMm = 32'767;
constexpr int kNoDepth = 65'535;

std::map<Utime, fs::path> read_list(const fs::path& file) {
  std::ifstream lines(file);
  if (!lines) throw_input_error("{}: cannot be opened", file.string());
  std::map<Utime, fs::path> list;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string first;
    if (!(words >> first) || first.front() == '#') continue;
    double stamp = 0.0;
    std::string name;
    if (!(std::istringstream(first) >> stamp) || !(words >> name) || !(stamp >= 0.0 && stamp < 1e12)) {
      throw_input_error("{}:{}: '{}' is not a stamp and a file's name", file.string(), number, line);
    }
    const Utime utime = from_seconds(stamp);
    if (!list.empty() && utime <= list.rbegin()->first)
      throw_input_error("{}:{}: stamps must increase", file.string(), number);
    list.emplace(utime, file.parent_path() / name);
  }
  return list;
}

std::optional<SE3> pose_at(const Trajectory& trajectory, Utime utime) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), utime,
                                      [](const StampedPose& pose, Utime time) { return pose.utime < time; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->utime == utime) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose& before = *(after - 1);
  const Utime gap_us = after->utime - before.utime;
  if (gap_us > kPoseGapUs) return std::nullopt;
  return interpolate(before.pose, after->pose, to_seconds(utime - before.utime) / to_seconds(gap_us));
}

fs::path nearest(const std::map<Utime, fs::path>& list, Utime utime) {
  const auto after = list.lower_bound(utime);
  auto best = after;
  if (after != list.begin() &&
      (after == list.end() || utime - std::prev(after)->first < after->first - utime))
    best = std::prev(after);
  if (best == list.end() || std::abs(best->first - utime) > kColourWithinUs) return {};
  return best->second;
}

RgbdFolder read_tum_layout(const fs::path& folder) {
  RgbdFolder result{.frames = {}, .depth_per_m = kTumDepthPerM};
  const std::map<Utime, fs::path> depths = read_list(folder / "depth.txt");
  const std::map<Utime, fs::path> colours = read_list(folder / "rgb.txt");
  const Trajectory poses = read_tum(folder / "groundtruth.txt");
  for (const auto& [utime, depth] : depths) {
    if (const std::optional<SE3> pose = pose_at(poses, utime)) {
      result.frames.push_back({utime, *pose, depth, nearest(colours, utime), {}});
    } else {
      ++result.without_pose;
    }
  }
  return result;
}

// None where it is not a pose: 7-Scenes writes INF where tracking was lost.
std::optional<SE3> read_pose(const fs::path& file) {
  std::ifstream numbers(file);
  Eigen::Matrix4d T;
  for (int i = 0; i < 16; ++i) {
    if (!(numbers >> T(i / 4, i % 4))) return std::nullopt;
  }
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  if (!T.allFinite() || (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() > 0.05) return std::nullopt;
  return SE3::from_matrix(T);
}

RgbdFolder read_frame_layout(const fs::path& folder) {
  constexpr std::string_view kDepth = ".depth.png";
  constexpr std::string_view kFrame = "frame-";
  RgbdFolder result{.frames = {}, .depth_per_m = kFrameDepthPerM};
  std::map<std::int64_t, std::string> stems;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kFrame) || !name.ends_with(kDepth)) continue;
    const std::string stem = name.substr(0, name.size() - kDepth.size());
    const std::string digits = stem.substr(kFrame.size());
    if (digits.empty() || digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos)
      throw_input_error("{}: '{}' is not a frame's number", entry.path().string(), digits);
    stems.emplace(std::stoll(digits), stem);
  }
  const auto existing = [&folder](const std::string& name) {
    return fs::exists(folder / name) ? folder / name : fs::path();
  };
  for (const auto& [number, stem] : stems) {
    const std::optional<SE3> pose = read_pose(folder / (stem + ".pose.txt"));
    if (!pose) {
      ++result.without_pose;
      continue;
    }
    RgbdFrame frame{kFirstFrameUs + number * kUsPerSecond / kFramesPerSecond, *pose,
                    folder / (stem + ".depth.png"), existing(stem + ".color.png"),
                    existing(stem + ".segm.png")};
    if (frame.colour.empty()) frame.colour = existing(stem + ".color.jpg");
    result.frames.push_back(std::move(frame));
  }
  return result;
}

cv::Mat load(const fs::path& file, int flags, int type, const cv::Size& size) {
  const cv::Mat picture = cv::imread(file.string(), flags);
  if (picture.empty()) throw_input_error("{}: cannot be read as a picture", file.string());
  if (picture.type() != type)
    throw_input_error("{}: not the kind of picture that is expected here", file.string());
  if (!size.empty() && picture.size() != size)
    throw_input_error("{}: its size differs from that of the depth image", file.string());
  return picture;
}

}  // namespace

RgbdFolder read_rgbd(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw_input_error("--tum-rgbd {}: not a folder", folder.string());
  RgbdFolder result = fs::exists(folder / "depth.txt") ? read_tum_layout(folder) : read_frame_layout(folder);
  if (result.frames.empty()) {
    throw_input_error(
        "--tum-rgbd {}: no depth image with a pose; expected are depth.txt, rgb.txt and groundtruth.txt, or "
        "frame-XXXXXX.depth.png and .pose.txt",
        folder.string());
  }
  return result;
}

depth_t load_depth(const RgbdFrame& frame, double depth_per_m) {
  const cv::Mat depth = load(frame.depth, cv::IMREAD_UNCHANGED, CV_16UC1, {});
  depth_t image{};
  image.utime = frame.utime;
  image.width = depth.cols;
  image.height = depth.rows;
  const double mm = 1000.0 / depth_per_m;
  for (auto value = depth.begin<std::uint16_t>(); value != depth.end<std::uint16_t>(); ++value) {
    const long depth_mm = *value == kNoDepth ? 0 : std::lround(mm * *value);
    image.depth_mm.push_back(static_cast<std::int16_t>(depth_mm > kMostDepthMm ? 0 : depth_mm));
  }
  image.n_depth = static_cast<std::int32_t>(image.depth_mm.size());
  if (!frame.colour.empty()) {
    const cv::Mat colour = load(frame.colour, cv::IMREAD_COLOR, CV_8UC3, depth.size());
    image.colours.reserve(3 * image.depth_mm.size());
    for (auto bgr = colour.begin<cv::Vec3b>(); bgr != colour.end<cv::Vec3b>(); ++bgr)
      image.colours.insert(image.colours.end(), {(*bgr)[2], (*bgr)[1], (*bgr)[0]});
    image.n_colours = static_cast<std::int32_t>(image.colours.size());
  }
  if (!frame.labels.empty()) {
    const cv::Mat labels = load(frame.labels, cv::IMREAD_UNCHANGED, CV_8UC1, depth.size());
    image.labels.assign(labels.begin<std::uint8_t>(), labels.end<std::uint8_t>());
    image.n_labels = static_cast<std::int32_t>(image.labels.size());
  }
  return image;
}

}  // namespace covey
