// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A point of the scene seen by a camera. The point is stored as l = (a, b, w): where the camera that stood at T_O_A would see it on z = 1, and its
// inverse depth there, so that far points, even at infinity, are as well-behaved as near ones. T_O_A is a chart, a constant of the landmark: the
// point does not move with the estimate of the pose that it was first seen from, and each factor touches one pose only.
//
//   q = R_C_O (R_O_A (a, b, 1) + w t_O_A) + w t_C_O      p_C times w
//   r = q_xy / q_z - measured
//
// Inverse depth: Civera, Davison, Montiel, "Inverse Depth Parametrization for Monocular SLAM", T-RO 2008.

#include "core/geometry/rig.h"
#include "core/graph/factor.h"
#include "core/vision/tracks.h"

namespace covey::vio {

struct Landmark {
  SE3 T_O_A;
  Eigen::Vector3d l{0.0, 0.0, 0.0};  // a, b, w (1/m)
};

struct ProjectionFactor {
  using Variables = graph::VariableList<SE3, graph::Vector<3>>;  // T_O_B, l
  static constexpr int kDim = 2;

  SE3 T_C_B;
  SE3 T_O_A;
  Eigen::Vector2d measured;
  graph::Occasion occasion = {};  // series: one for each camera

  Eigen::Vector2d evaluate(const SE3& T_O_B, const Eigen::Vector3d& l, Eigen::Matrix<double, 2, 6>* J_pose,
                           Eigen::Matrix<double, 2, 3>* J_landmark) const;
};

// The rig's cameras.
struct StereoRig {
  explicit StereoRig(const Rig& rig);

  SE3 T_L_B;
  SE3 T_R_B;  // of one camera alone: identity, since nothing is seen by another
};

// Whether the landmark lies in front of every camera that saw it from T_O_B, at most `gate` sigmas from where it was seen.
bool agrees(const StereoRig& rig, const SE3& T_O_B, const Landmark& landmark, const TrackObservation& seen,
            double gate);

}  // namespace covey::vio
