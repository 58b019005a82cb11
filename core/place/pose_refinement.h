// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The pose between two cameras from points that both see, with the points' places as unknowns too: each camera's view of a point
// is its direction on the plane z = 1 and, where a depth was measured, its inverse (whose error hardly depends on the distance, since
// it is that of the disparity). What neither camera can see well is so weighed as it deserves, and the marginal covariance of
// the pose is honest about points that are far, few or all on one side.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/graph/factor.h"
#include "core/place/features.h"

namespace covey::place {

// What a camera measures of a point: [x / z; y / z; 1 / z], the third where depth is known (kDim = 3).
template <int kDimension>
struct OwnView {
  using Variables = graph::VariableList<graph::Vector<3>>;
  static constexpr int kDim = kDimension;
  graph::Vector<kDim> measured;
  graph::Vector<kDim> evaluate(const Eigen::Vector3d& p_C, Eigen::Matrix<double, kDim, 3>* J) const;
};

// The same from a second camera D: of p_C, seen at T_C_D^-1 p_C.
template <int kDimension>
struct OtherView {
  using Variables = graph::VariableList<SE3, graph::Vector<3>>;
  static constexpr int kDim = kDimension;
  graph::Vector<kDim> measured;
  graph::Vector<kDim> evaluate(const SE3& T_C_D, const Eigen::Vector3d& p_C,
                               Eigen::Matrix<double, kDim, 6>* J_T,
                               Eigen::Matrix<double, kDim, 3>* J_p) const;
};

struct RefinedPose {
  SE3 T_C_D;
  Matrix6d covariance = Matrix6d::Zero();  // [rho; phi] in D, by that noise
  // Squared residuals over degrees of freedom: how much larger squared errors are than the cameras' noise says.
  double variance_factor = 1.0;
  std::vector<std::pair<int, int>> agreeing{};  // those of the pairs that fit
};

// From a start that RANSAC gave. Its inliers agree with a pose made from three of them, noise and all; so the pairs are gathered
// anew, all that come within `gather` (on the plane z = 1) of the start, and after solving those that do not fit are left out. Nothing
// where the pairs do not determine the pose.
std::optional<RefinedPose> refine_pose(const FrameFeatures& c, const FrameFeatures& d,
                                       const std::vector<std::pair<int, int>>& pairs, const SE3& T_C_D,
                                       double gather);

}  // namespace covey::place
