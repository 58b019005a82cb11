// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/external_odometry.h"

#include <cmath>
#include <numbers>

#include "core/base/angle.h"
#include "core/vio/team_keyframes.h"

namespace covey::vio {
namespace {

constexpr int kLateInARow = 20;  // late poses in a row

// The yaw of the body's x axis; of its y axis less a quarter turn where x stands upright.
double yaw_of(const SO3& R) {
  const Eigen::Matrix3d m = R.matrix();
  constexpr double kUpright = 0.9;
  if (std::abs(m(2, 0)) < kUpright) return std::atan2(m(1, 0), m(0, 0));
  return std::atan2(-m(0, 1), m(1, 1));
}

Matrix6d moved(const Matrix6d& covariance, const SE3& step) {
  const Matrix6d Ad = step.inverse().adjoint();
  return Ad * covariance * Ad.transpose();
}

}  // namespace

ExternalOdometryOptions read_external_odometry_options(ConfigSection& section) {
  ExternalOdometryOptions options;
  section.read("sigma_m", options.sigma_m, 1e-6, 10.0);
  section.read("sigma_deg", options.sigma_deg, 1e-6, 90.0);
  section.read("gravity_sigma_deg", options.gravity_sigma_deg, 0.0, 90.0);
  section.read("max_speed_mps", options.max_speed_mps, 0.1, 1000.0);
  return options;
}

VioFrame ExternalOdometry::add(const OdometryPose& pose) {
  VioFrame frame;
  const bool late = segment_ && pose.utime <= segment_->last.utime;
  late_ = late ? late_ + 1 : 0;
  if (late && late_ <= kLateInARow) {
    frame.dropped = "late";
    return frame;
  }
  if (!segment_ || late || begins_anew(pose)) {
    late_ = 0;
    open(pose, frame);
  } else {
    step(pose, frame);
  }
  frame.health.phase = VioPhase::kTracking;
  frame.health.segments = segment_->segments;
  return frame;
}

bool ExternalOdometry::begins_anew(const OdometryPose& pose) const {
  const OdometryPose& last = segment_->last;
  const double way = (pose.T_O_B.translation - last.T_O_B.translation).norm();
  return pose.segment != last.segment || way > odometry_.max_speed_mps * to_seconds(pose.utime - last.utime);
}

void ExternalOdometry::open(const OdometryPose& pose, VioFrame& frame) {
  const int segments = segment_ ? segment_->segments + 1 : 1;
  segment_.emplace();
  segment_->name = pose.utime;
  segment_->segments = segments;
  const SO3 upright = SO3::exp({0.0, 0.0, -yaw_of(pose.T_O_B.rotation)});
  segment_->T_O_S = {upright, -(upright * pose.T_O_B.translation)};
  segment_->last = pose;
  segment_->T_O_B = segment_->T_O_S * pose.T_O_B;
  segment_->keyframe = make_keyframe(0);
  VioState state;
  state.utime = pose.utime;
  state.segment = segment_->name;
  state.state.T_W_B = segment_->T_O_B;
  frame.states.push_back(state);
  frame.keyframes.push_back(segment_->keyframe);
}

void ExternalOdometry::step(const OdometryPose& pose, VioFrame& frame) {
  ExternalSegment& segment = *segment_;
  const SE3 T_O_B = segment.T_O_S * pose.T_O_B;
  const SE3 step = segment.T_O_B.inverse() * T_O_B;
  const Matrix6d step_sigma = step_covariance(pose, step);
  const double dt = to_seconds(pose.utime - segment.last.utime);
  VioState state;
  state.utime = pose.utime;
  state.segment = segment.name;
  state.state.T_W_B = T_O_B;
  state.state.v_W = (T_O_B.translation - segment.T_O_B.translation) / dt;
  segment.covariance = moved(segment.covariance, step) + step_sigma;
  segment.keyframe_covariance = moved(segment.keyframe_covariance, step) + step_sigma;
  const Eigen::Matrix3d R_O_B = T_O_B.rotation.matrix();
  state.covariance.topLeftCorner<6, 6>() = segment.covariance;
  state.covariance.bottomRightCorner<3, 3>() =
      R_O_B * step_sigma.topLeftCorner<3, 3>() * R_O_B.transpose() / (dt * dt);
  segment.T_O_B = T_O_B;
  segment.last = pose;
  frame.states.push_back(state);
  const SE3 T_P_B = segment.keyframe.T_O_K.inverse() * T_O_B;
  if (!team_keyframe_due(options_, T_P_B, to_seconds(pose.utime - segment.keyframe.utime))) return;
  VioKeyframe keyframe = make_keyframe(segment.keyframe.id + 1);
  keyframe.T_P_K = T_P_B;
  keyframe.covariance = segment.keyframe_covariance;
  segment.keyframe_covariance.setZero();
  segment.keyframe = keyframe;
  frame.keyframes.push_back(keyframe);
}

Matrix6d ExternalOdometry::step_covariance(const OdometryPose& pose, const SE3& step) const {
  if (!pose.covariance.isZero()) return pose.covariance;
  constexpr double kMetresPerRadian = 0.5;
  constexpr double kLeastWay = 1e-4;  // a covariance can be inverted, standing too
  const double way = step.translation.norm() + kMetresPerRadian * step.rotation.log().norm() + kLeastWay;
  const double sigma_rad = odometry_.sigma_deg * kDegree;
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(odometry_.sigma_m * odometry_.sigma_m),
      Eigen::Vector3d::Constant(sigma_rad * sigma_rad);
  return Matrix6d((way * variances).asDiagonal());
}

VioKeyframe ExternalOdometry::make_keyframe(int id) const {
  VioKeyframe keyframe;
  keyframe.utime = segment_->last.utime;
  keyframe.segment = segment_->name;
  keyframe.id = id;
  keyframe.T_O_K = segment_->T_O_B;
  keyframe.gravity_sigma_rad = odometry_.gravity_sigma_deg * kDegree;
  keyframe.gravity_K = Eigen::Vector3d::Zero();
  if (odometry_.gravity_sigma_deg > 0.0) keyframe.gravity_K = gravity_direction(segment_->T_O_B);
  return keyframe;
}

}  // namespace covey::vio
