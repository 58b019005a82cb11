// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A small RGB-D recording, written by a test: a wall 2 m ahead of a camera that moves along its x by 1 cm from image to image. The picture has
// 64 x 48 pixels; image k is of red 10 + k.

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/core/pgo/scratch.h"

namespace covey {

struct RgbdStage : ScratchFile {
  static cv::Mat depth(double per_m) { return {48, 64, CV_16UC1, cv::Scalar(2.0 * per_m)}; }
  static cv::Mat colour(int k) { return {48, 64, CV_8UC3, cv::Scalar(7, 8, 10 + k)}; }

  // frame-00000{0,5,...}.*
  void write_frames(int images) const {
    std::filesystem::create_directories(path);
    for (int k = 0; k < images; ++k) {
      const std::string stem = (path / fmt::format("frame-{:06}", 5 * k)).string();
      cv::imwrite(stem + ".depth.png", depth(1000.0));
      cv::imwrite(stem + ".color.png", colour(k));
      cv::imwrite(stem + ".segm.png", cv::Mat(48, 64, CV_8UC1, cv::Scalar(3)));
      std::ofstream(stem + ".pose.txt") << "1 0 0 " << 0.01 * k << "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
    }
  }

  // Depth at 100.1, 100.3, ... s, colour 5 ms later, poses every 0.05 s from 100 s on.
  void write_tum(int images) const {
    std::filesystem::create_directories(path);
    std::ofstream depths(path / "depth.txt");
    std::ofstream colours(path / "rgb.txt");
    std::ofstream poses(path / "groundtruth.txt");
    depths << "# depth maps\n";
    for (int k = 0; k < images; ++k) {
      depths << fmt::format("{:.6f} depth{}.png\n", 100.1 + 0.2 * k, k);
      colours << fmt::format("{:.6f} rgb{}.png\n", 100.105 + 0.2 * k, k);
      cv::imwrite((path / fmt::format("depth{}.png", k)).string(), depth(5000.0));
      cv::imwrite((path / fmt::format("rgb{}.png", k)).string(), colour(k));
    }
    for (int i = 0; i <= 4 * images; ++i)
      poses << fmt::format("{:.6f} {:.6f} 0 0 0 0 0 1\n", 100.0 + 0.05 * i, 0.0025 * i);
  }

  // Its rig, and the robot that carries it. Returns the robot's file.
  std::filesystem::path write_config() const {
    const std::string camera =
        "{width: 64, height: 48, intrinsics: [50, 50, 31.5, 23.5], T_B_C: [0, 0, 1, 0, -1, 0, 0, 0, 0, -1, "
        "0, 0, 0, 0, 0, 1]}\n";
    std::filesystem::create_directories(path);
    std::ofstream(path / "rig.yaml") << "left: " << camera << "depth: " << camera;
    std::ofstream(path / "robot.yaml") << "sensors: rig.yaml\nmesher: {voxel_m: 0.05}\n";
    return path / "robot.yaml";
  }
};

}  // namespace covey
