// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A robot's mesh as it was measured: in the frames O of its odometry, with the keyframes that saw it, before anything is
// known of the team.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/se3.h"

namespace covey::mesh {

using Face = std::array<std::uint32_t, 3>;  // vertices, counter-clockwise seen from the free side

// A keyframe as odometry had it and as the team has it now.
struct PlacedKeyframe {
  Utime utime = 0;
  Utime segment = 0;  // whose O it is in; O is another frame in every segment
  std::int32_t id = 0;
  SE3 T_O_K;
  SE3 T_W_K;

  SE3 correction() const { return T_W_K * T_O_K.inverse(); }  // where this keyframe takes what it saw
};

struct MeasuredMesh {
  std::vector<Eigen::Vector3f> p_O;   // m, each in the O of its keyframe's segment
  std::vector<std::int32_t> seen_by;  // index of the newest keyframe that saw the vertex; never negative
  std::vector<Face> faces;
};

}  // namespace covey::mesh
