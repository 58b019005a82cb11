// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Recorded colour and depth images with their poses, in one of two layouts:
//  - TUM RGB-D: rgb.txt, depth.txt (`stamp file`, stamps in seconds) and groundtruth.txt (TUM text, poses of the camera); depth in 1/5000 m.
//    Colour is the nearest within 20 ms; the pose is interpolated at the depth's stamp, over at most 0.1 s;
//  - frame-XXXXXX.depth.png, .color.png or .jpg, .pose.txt (4x4, camera to world; made a rigid motion again), and .segm.png (labels) where
//    there is one: 7-Scenes and its like. Depth in 1/1000 m; 30 numbers are a second, number 0 has the stamp 1 s.
// Frames without a pose are left out and counted. Depth of 0 or of 65535 is none. Colour and labels are taken as registered to depth.
//
// InputError that names file and line: what cannot be opened or read, stamps that do not increase, a folder in neither layout.

#include <covey/depth_t.hpp>
#include <filesystem>
#include <vector>

#include "core/geometry/trajectory.h"

namespace covey {

struct RgbdFrame {
  Utime utime = 0;
  SE3 T_D_C;  // of the depth camera in the data's own frame D
  std::filesystem::path depth;
  std::filesystem::path colour;  // empty: none
  std::filesystem::path labels;  // empty: none
};

struct RgbdFolder {
  std::vector<RgbdFrame> frames;
  double depth_per_m = 1000.0;  // numbers of the depth images per metre
  int without_pose = 0;
};

RgbdFolder read_rgbd(const std::filesystem::path& folder);

// InputError where a picture cannot be read or has another size or kind than it should.
depth_t load_depth(const RgbdFrame& frame, double depth_per_m);

}  // namespace covey
