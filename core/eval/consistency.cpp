// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/consistency.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

namespace covey {
namespace {

using Vector4d = Eigen::Vector4d;

std::optional<SE3> pose_at(const Trajectory& trajectory, Utime utime) {
  constexpr Utime kLongestGapUs = 60'000;
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), utime,
                                      [](const StampedPose& pose, Utime t) { return pose.utime < t; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->utime == utime) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = after - 1;
  const auto gap = after->utime - before->utime;
  if (gap > kLongestGapUs) return std::nullopt;
  return interpolate(before->pose, after->pose,
                     static_cast<double>(utime - before->utime) / static_cast<double>(gap));
}

// W from O by a turn about the vertical and a shift, so that one pose is right but for its tilt.
SE3 place_level(const SE3& T_W_B, const SE3& T_O_B) {
  const Eigen::Matrix3d R = T_W_B.rotation.matrix() * T_O_B.rotation.matrix().transpose();
  const SO3 R_W_O = SO3::exp({0.0, 0.0, std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1))});
  return {R_W_O, T_W_B.translation - R_W_O * T_O_B.translation};
}

// e^T P^-1 e over the degrees of freedom.
double normalised(const Eigen::VectorXd& e, const Eigen::MatrixXd& P) {
  return e.dot(P.llt().solve(e)) / static_cast<double>(e.size());
}

// Positions first.
class Mean {
 public:
  void add(const Eigen::VectorXd& e, const Eigen::MatrixXd& P) {
    if (P.llt().info() != Eigen::Success) return;
    const Eigen::Index rest = e.size() - 3;
    sum_ += Eigen::Vector3d(normalised(e, P), normalised(e.head<3>(), P.topLeftCorner<3, 3>()),
                            normalised(e.tail(rest), P.bottomRightCorner(rest, rest)));
    ++count_;
  }
  Nees result() const {
    const Eigen::Vector3d mean = sum_ / std::max(count_, 1);
    return {count_, mean[0], mean[1], mean[2]};
  }

 private:
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  int count_ = 0;
};

}  // namespace

Nees state_nees(const std::vector<PoseBelief>& states, const Trajectory& reference) {
  Mean mean;
  std::optional<SE3> T_W_O;
  Utime segment = 0;
  for (const PoseBelief& state : states) {
    const auto T_W_B = pose_at(reference, state.utime);
    if (!T_W_B) continue;
    if (!T_W_O || state.segment != segment) {  // this state's own error is zero by the choice of W
      T_W_O = place_level(*T_W_B, state.T_O_B);
      segment = state.segment;
      continue;
    }
    const Vector6d xi = (state.T_O_B.inverse() * T_W_O->inverse() * *T_W_B).log();
    const Eigen::Matrix3d R_O_B = state.T_O_B.rotation.matrix();
    Eigen::Matrix<double, 4, 6> A = Eigen::Matrix<double, 4, 6>::Zero();
    A.topLeftCorner<3, 3>() = R_O_B;
    A.bottomRightCorner<1, 3>() = R_O_B.row(2);
    mean.add(Vector4d(A * xi), Eigen::Matrix4d(A * state.covariance * A.transpose()));
  }
  return mean.result();
}

Nees edge_nees(const std::vector<EdgeBelief>& edges, const Trajectory& reference, double span_s) {
  Mean mean;
  const EdgeBelief* previous = nullptr;
  Utime begin = 0;
  SE3 T_A_K;
  Matrix6d covariance = Matrix6d::Zero();
  for (const EdgeBelief& edge : edges) {
    const bool follows = previous && edge.segment == previous->segment && edge.id == previous->id + 1;
    if (follows) {
      const Matrix6d Ad = edge.T_P_K.inverse().adjoint();
      covariance = Ad * covariance * Ad.transpose() + edge.covariance;
      T_A_K = T_A_K * edge.T_P_K;
    }
    const bool complete = follows && to_seconds(edge.utime - begin) >= span_s;
    if (complete) {
      const auto T_W_A = pose_at(reference, begin);
      const auto T_W_K = pose_at(reference, edge.utime);
      if (T_W_A && T_W_K) mean.add(Vector6d((T_A_K.inverse() * T_W_A->inverse() * *T_W_K).log()), covariance);
    }
    if (!follows || complete) {
      begin = edge.utime;
      T_A_K = SE3{};
      covariance.setZero();
    }
    previous = &edge;
  }
  return mean.result();
}

}  // namespace covey
