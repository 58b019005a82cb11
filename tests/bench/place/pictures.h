// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The stereo pictures of keyframes of a simulated world, rendered when they are asked for, or kept in a folder as
// robot<r>/<utime>_{left,right}.png.

#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "core/geometry/rig.h"
#include "core/sim/cameras.h"
#include "core/sim/scenario.h"
#include "tests/bench/place/view.h"

namespace covey::bench {

// Each 0.5 m, 15 deg or 1 s, as vio cuts them, of every robot; in the order of time.
std::vector<View> cut_keyframes(const sim::Scenario& scenario);

class Pictures {
 public:
  // An empty folder: nothing is kept. World and rig must outlive it.
  Pictures(std::filesystem::path folder, const sim::MeshWorld& world, const Rig& rig, std::uint64_t seed);

  std::pair<cv::Mat, cv::Mat> take(const View& view);

 private:
  std::pair<cv::Mat, cv::Mat> render(const View& view);

  std::filesystem::path folder_;
  const sim::MeshWorld& world_;
  const Rig& rig_;
  std::uint64_t seed_;
  std::unique_ptr<sim::SensorCameras> cameras_;  // made when something is to be rendered
};

}  // namespace covey::bench
