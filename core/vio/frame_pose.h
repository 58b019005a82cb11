// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where a frame was taken, against landmarks that are held where they are: a few steps for one pose (and velocity), cheap enough for every frame.

#include <map>

#include "core/imu/preintegration.h"
#include "core/vio/projection_factor.h"
#include "core/vision/tracks.h"

namespace covey::vio {

using Landmarks = std::map<std::int64_t, Landmark>;  // by track

// What the IMU says: the increment from a state that is held where it is.
struct ImuLink {
  NavState from;
  Preintegration increment;
};

struct FramePose {
  NavState state;
  int used = 0;  // tracks that agree with their landmarks to `gate` sigmas in every camera that saw them
  std::vector<std::int64_t> outliers;  // tracks that do not
};

// From `guess` downhill; its bias stays. Without a link the velocity stays, too, and the guess may be some tenths of a metre off.
FramePose place_frame(const StereoRig& rig, const Landmarks& landmarks, const FrameTracks& frame,
                      const NavState& guess, const ImuLink* link, double gate);

}  // namespace covey::vio
