// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What IMU samples say about the states at both ends, and how biases wander. Forster et al., T-RO 2017, equations 45 and 48:
//
//   ImuFactor   r = [ R_i^T (p_j - p_i - v_i T - g T^2 / 2) - dp(b_i)        position, m
//                     Log(dR(b_i)^T R_i^T R_j)                               rotation, rad
//                     R_i^T (v_j - v_i - g T) - dv(b_i) ]                    velocity, m/s
//   BiasWalk    r = b_j - b_i                                                [gyro; accel]
//
//   graph.add(ImuFactor{increment}, {pose_i, velocity_i, bias_i, pose_j, velocity_j}, imu_noise(increment));
//   graph.add(BiasWalk{}, {bias_i, bias_j}, bias_walk_noise(rig.imu, increment.duration_s()));

#include "core/graph/factor.h"
#include "core/imu/preintegration.h"

namespace covey {

struct ImuFactor {
  using Variables = graph::VariableList<SE3, graph::Vector<3>, graph::Vector<6>, SE3,
                                        graph::Vector<3>>;  // x_i, v_i, b_i, x_j, v_j
  static constexpr int kDim = 9;
  using PoseJacobian = Eigen::Matrix<double, 9, 6>;
  using VelocityJacobian = Eigen::Matrix<double, 9, 3>;

  Preintegration increment;
  Eigen::Vector3d gravity = kGravity;

  Vector9d evaluate(const SE3& T_i, const Eigen::Vector3d& v_i, const Vector6d& bias_i, const SE3& T_j,
                    const Eigen::Vector3d& v_j, PoseJacobian* J_T_i, VelocityJacobian* J_v_i,
                    PoseJacobian* J_bias, PoseJacobian* J_T_j, VelocityJacobian* J_v_j) const;
};

struct BiasWalk {
  using Variables = graph::VariableList<graph::Vector<6>, graph::Vector<6>>;
  static constexpr int kDim = 6;

  Vector6d evaluate(const Vector6d& b_i, const Vector6d& b_j, Matrix6d* J_i, Matrix6d* J_j) const;
};

graph::Noise<9> imu_noise(const Preintegration& increment);
graph::Noise<6> bias_walk_noise(const ImuNoise& imu, double duration_s);

}  // namespace covey
