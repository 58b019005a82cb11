// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Frames of 7-Scenes (Shotton et al., CVPR 2013): colour, depth and the camera's pose. The depth image is not registered to the colour
// camera, whose focal length is that of its make.

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "core/geometry/rig.h"
#include "tests/bench/place/view.h"

namespace covey::bench {

struct SceneFrame {
  cv::Mat image;    // grey
  cv::Mat depth_m;  // as the colour camera would have it, nearly; 0: none
};

MountedCamera scene_camera();

// Cut in the middle: what comes before is robot 0's, what comes after robot 1's, both from the beginning of time on. InputError where the
// folder has no frames.
std::vector<View> scene_views(const std::filesystem::path& folder);
SceneFrame read_scene_frame(const std::filesystem::path& folder, const View& view);

}  // namespace covey::bench
