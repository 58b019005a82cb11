// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A landmark from the views of one track: its direction is where the reference view saw it, its inverse depth w the least-squares solution of the
// equations q_xy = q_z m of all other views, which are linear in w.

#include <span>

#include "core/vio/projection_factor.h"
#include "core/vision/tracks.h"

namespace covey::vio {

struct View {
  SE3 T_O_B;
  const TrackObservation* seen = nullptr;
};

// With the last view that has a match in the right picture as the chart, or the last one. Nothing where w is not known to `max_sigma` (1/m), lies
// behind the cameras, or leaves a residual of more than `gate` sigmas in any view.
std::optional<Landmark> triangulate(const StereoRig& rig, std::span<const View> views, double gate,
                                    double max_sigma = 0.1);

}  // namespace covey::vio
