// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/projection_factor.h"

namespace covey::vio {
namespace {

// Of depth now over depth in the chart: nearer to the camera's plane a projection says nothing.
constexpr double kNearest = 0.02;

bool sees(const SE3& T_C_B, const SE3& T_O_B, const Landmark& landmark, const Eigen::Vector2d& m,
          double limit) {
  const SE3 T_C_A = T_C_B * T_O_B.inverse() * landmark.T_O_A;
  const Eigen::Vector3d q = T_C_A.rotation * Eigen::Vector3d(landmark.l.x(), landmark.l.y(), 1.0) +
                            landmark.l.z() * T_C_A.translation;
  return q.z() > kNearest && (q.head<2>() / q.z() - m).norm() < limit;
}

}  // namespace

Eigen::Vector2d ProjectionFactor::evaluate(const SE3& T_O_B, const Eigen::Vector3d& l,
                                           Eigen::Matrix<double, 2, 6>* J_pose,
                                           Eigen::Matrix<double, 2, 3>* J_landmark) const {
  const double w = l.z();
  const Eigen::Matrix3d R_C_B = T_C_B.rotation.matrix();
  const Eigen::Matrix3d R_B_O = T_O_B.rotation.matrix().transpose();
  const Eigen::Matrix3d R_O_A = T_O_A.rotation.matrix();
  const Eigen::Vector3d t = T_O_A.translation - T_O_B.translation;
  const Eigen::Vector3d q_B = R_B_O * (R_O_A * Eigen::Vector3d(l.x(), l.y(), 1.0) + w * t);
  const Eigen::Vector3d q = R_C_B * q_B + w * T_C_B.translation;
  if (!(q.z() > kNearest)) {
    if (J_pose) {
      J_pose->setZero();
      J_landmark->setZero();
    }
    return Eigen::Vector2d::Zero();
  }
  const double inverse = 1.0 / q.z();
  const Eigen::Vector2d m = inverse * q.head<2>();
  if (J_pose) {
    Eigen::Matrix<double, 2, 3> J_q;
    J_q << inverse, 0.0, -m.x() * inverse, 0.0, inverse, -m.y() * inverse;
    const Eigen::Matrix<double, 2, 3> J_q_B = J_q * R_C_B;
    J_pose->leftCols<3>() = -w * J_q_B;
    J_pose->rightCols<3>() = J_q_B * hat(q_B);
    const Eigen::Matrix<double, 2, 3> J_O = J_q_B * R_B_O;
    J_landmark->leftCols<2>() = J_O * R_O_A.leftCols<2>();
    J_landmark->col(2) = J_O * t + J_q * T_C_B.translation;
  }
  return m - measured;
}

StereoRig::StereoRig(const Rig& rig)
    : T_L_B(rig.left.T_B_C.inverse()), T_R_B(rig.right ? rig.right->T_B_C.inverse() : SE3{}) {}

bool agrees(const StereoRig& rig, const SE3& T_O_B, const Landmark& landmark, const TrackObservation& seen,
            double gate) {
  const double limit = gate * seen.sigma;
  return sees(rig.T_L_B, T_O_B, landmark, seen.left, limit) &&
         (!seen.right || sees(rig.T_R_B, T_O_B, landmark, *seen.right, limit));
}

}  // namespace covey::vio
