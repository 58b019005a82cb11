// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which parts of a world a depth camera could have measured on its way: points that it saw, in front of everything else and
// within its range, at some pose. The world is drawn from every pose of the way that differs enough from the one before.

#include <vector>

#include "core/eval/surface.h"
#include "core/geometry/rig.h"
#include "core/geometry/trajectory.h"
#include "viewer_offscreen/renderer.h"

namespace covey {

struct SeenOptions {
  double every_m = 0.3;  // or:
  double every_rad = 0.15;
  double tolerance_m = 0.05;  // behind what was drawn at its pixel, plus 2 % of the depth
};

// By point, true where it was seen from one of the ways (T_W_B).
std::vector<bool> seen_points(viewer::Renderer& renderer, const viewer::Mesh& world,
                              const std::vector<SurfacePoint>& points, const std::vector<Trajectory>& ways,
                              const DepthCamera& camera, const SeenOptions& options = {});

}  // namespace covey
