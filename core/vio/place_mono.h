// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where one camera stood at some frames, up to scale, from its tracks alone. Rotations begin as the gyroscope has them, positions all at one place and
// landmarks all at one distance; bundle adjustment converges from there where the way is short against the scene (Yu, Gallup, "3D Reconstruction from
// Accidental Motion", CVPR 2014), which a second or two of a vehicle's way is.

#include <span>
#include <vector>

#include "core/geometry/so3.h"
#include "core/vision/tracks.h"

namespace covey::vio {

struct MonoPlaces {
  std::vector<SE3> T_V_C;  // V: the first camera's frame; empty where the tracks do not hold together
  double parallax = 0.0;   // on z = 1, median between first and last frame, rotation taken out
};

// rotations: R_V_C as predicted, the first one identity.
MonoPlaces place_mono(std::span<const FrameTracks* const> frames, std::span<const SO3> rotations);

}  // namespace covey::vio
