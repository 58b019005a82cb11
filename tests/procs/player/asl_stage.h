// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A small recording in EuRoC's layout, written by a test. Stamps of the IMU rise by 5 ms, of the pictures by 50 ms; picture k is of grey 10 + k on the left.

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/core/pgo/scratch.h"

namespace covey {

struct AslStage : ScratchFile {
  static constexpr std::int64_t kFirstNs = 1'403'636'579'763'555'584;

  AslStage(int pictures, const std::string& extension) {
    std::filesystem::create_directories(path / "mav0/imu0");
    std::ofstream imu(path / "mav0/imu0/data.csv");
    imu << "#timestamp [ns],w_RS_S_x [rad s^-1],...\n";
    for (int i = 0; i < 10 * pictures; ++i) {
      imu << kFirstNs + 5'000'000LL * i << "," << i << ",-0.5,0.25,0.1,9.8,1e-3\r\n";
    }
    for (int camera = 0; camera < 2; ++camera) {
      const std::filesystem::path folder = path / ("mav0/cam" + std::to_string(camera));
      std::filesystem::create_directories(folder / "data");
      std::ofstream list(folder / "data.csv");
      list << "#timestamp [ns],filename\n";
      for (int k = 0; k < pictures; ++k) {
        const std::string stamp = std::to_string(kFirstNs + 50'000'000LL * k);
        list << stamp << ", " << stamp << extension << "\n";
        cv::imwrite((folder / "data" / (stamp + extension)).string(),
                    cv::Mat(30, 40, CV_8UC1, cv::Scalar(10 + k + 100 * camera)),
                    {cv::IMWRITE_WEBP_QUALITY, 101});
      }
    }
  }

  std::filesystem::path csv(const std::string& sensor) const { return path / "mav0" / sensor / "data.csv"; }
  void write(const std::string& sensor, const std::string& text) const { std::ofstream(csv(sensor)) << text; }
};

}  // namespace covey
