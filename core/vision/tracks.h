// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the front end says about one stereo frame: which points of the scene it sees again, and where. Coordinates are undistorted and lie on
// the plane z = 1 of the camera that saw them, so that nobody behind the front end needs a camera model:
//
//   left = (x / z, y / z) of p_C in the left camera's frame,   right = likewise in the right one's
//
// An id names one point as long as it is tracked without a break and is never given again. Only the header, without images: core/vio
// reads it.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/time.h"

namespace covey {

struct TrackObservation {
  std::int64_t id = 0;
  Eigen::Vector2d left = Eigen::Vector2d::Zero();
  std::optional<Eigen::Vector2d> right;  // where a stereo match was found in this frame
  double sigma = 0.0;                    // of each coordinate, on z = 1: pixels over focal length
};

struct FrameTracks {
  Utime utime = 0;                       // of the images
  std::vector<TrackObservation> tracks;  // by rising id
};

}  // namespace covey
