// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The terms of the deformation graph beside the keyframes' priors (pose_factors.h). Poses are of nodes or keyframes in W.
//
//   RigidTie        r = R_a g_ab + t_a - t_b       b stays where it was as seen from a: the paper's second term with
//                                                  g_ab = g_b - g_a, and its third with g_ab in the keyframe's frame
//   RotationPrior   r = Log(measured^-1 R)         of a pose's rotation alone
//
// Source: Tian et al., "Kimera-Multi", T-RO 2022, section VI; Sumner, Schmid, Pauly, "Embedded deformation for shape
// manipulation", SIGGRAPH 2007.

#include "core/graph/factor.h"

namespace covey::mesh {

struct RigidTie {
  using Variables = graph::VariableList<SE3, SE3>;
  static constexpr int kDim = 3;
  using Jacobian = Eigen::Matrix<double, 3, 6>;

  Eigen::Vector3d g_ab;

  Eigen::Vector3d evaluate(const SE3& a, const SE3& b, Jacobian* J_a, Jacobian* J_b) const {
    if (J_a) {
      const Eigen::Matrix3d R_a = a.rotation.matrix();
      *J_a << R_a, -R_a * hat(g_ab);
      *J_b << -b.rotation.matrix(), Eigen::Matrix3d::Zero();
    }
    return a * g_ab - b.translation;
  }
};

struct RotationPrior {
  using Variables = graph::VariableList<SE3>;
  static constexpr int kDim = 3;

  SO3 measured;

  Eigen::Vector3d evaluate(const SE3& x, Eigen::Matrix<double, 3, 6>* J) const {
    const Eigen::Vector3d r = (measured.inverse() * x.rotation).log();
    if (J) *J << Eigen::Matrix3d::Zero(), SO3::right_jacobian_inverse(r);
    return r;
  }
};

}  // namespace covey::mesh
