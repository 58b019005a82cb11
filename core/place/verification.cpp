// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/verification.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/place/minimal_poses.h"
#include "core/place/overlap.h"

namespace covey::place {
namespace {

constexpr double kRadPerDeg = 0.017453292519943295;

// Along the shorter axis of the cloud of directions.
double spread(const FrameFeatures& features, const std::vector<std::size_t>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (const std::size_t k : points) {
    const Eigen::Vector2d m = features.direction(k);
    mean += m;
    squares += m * m.transpose();
  }
  const auto n = static_cast<double>(points.size());
  mean /= n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(squares / n - mean * mean.transpose());
  return std::sqrt(std::max(0.0, eigen.eigenvalues()(0)));
}

bool are_spread(const FrameFeatures& a, const FrameFeatures& b, const Pairs& pairs, double least) {
  std::vector<std::size_t> in_a;
  std::vector<std::size_t> in_b;
  for (const auto& [i, j] : pairs) {
    in_a.push_back(static_cast<std::size_t>(i));
    in_b.push_back(static_cast<std::size_t>(j));
  }
  return spread(a, in_a) >= least && spread(b, in_b) >= least;
}

double largest_variance(const Eigen::Matrix3d& covariance) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues().maxCoeff();
}

bool is_certain(const Matrix6d& covariance, const VerificationOptions& options) {
  const double position = std::sqrt(largest_variance(covariance.topLeftCorner<3, 3>()));
  const double angle = std::sqrt(largest_variance(covariance.bottomRightCorner<3, 3>()));
  return position <= options.most_sigma_m && angle <= options.most_sigma_deg * kRadPerDeg;
}

Matrix6d floor_of(const VerificationOptions& options) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(std::pow(options.floor_m, 2)),
      Eigen::Vector3d::Constant(std::pow(options.floor_deg * kRadPerDeg, 2));
  return variances.asDiagonal();
}

Pairs swapped(const Pairs& pairs) {
  Pairs result;
  for (const auto& [i, j] : pairs) result.emplace_back(j, i);
  return result;
}

int depths(const FrameFeatures& features, const Pairs& pairs) {
  return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const auto& pair) {
    return features.has_depth(static_cast<std::size_t>(pair.first));
  }));
}

// With the depths of whichever camera has more.
PoseHypothesis metric_pose(const FrameFeatures& a, const FrameFeatures& b, const Pairs& pairs,
                           const VerificationOptions& options) {
  if (depths(a, pairs) >= depths(b, swapped(pairs))) {
    return three_point_ransac(a, b, pairs, options.ransac_direction, options.three_point_iterations);
  }
  PoseHypothesis pose =
      three_point_ransac(b, a, swapped(pairs), options.ransac_direction, options.three_point_iterations);
  return {swapped(pose.agreeing), pose.T_C_D.inverse()};
}

Verification refused(Verification result, const char* why) {
  result.refused = why;
  return result;
}

}  // namespace

Verification verify(const FrameFeatures& a, const FrameFeatures& b, const VerificationOptions& options) {
  Verification result;
  const Pairs matches = match_descriptors(a.descriptors, b.descriptors, options.match);
  result.matches = static_cast<int>(matches.size());
  if (result.matches < options.least_matches) return refused(result, "matches");

  const Pairs moved =
      five_point_ransac(a, b, matches, options.ransac_direction, options.five_point_iterations).agreeing;
  result.five_point = static_cast<int>(moved.size());
  if (result.five_point < options.least_inliers) return refused(result, "five_point");

  const PoseHypothesis metric = metric_pose(a, b, moved, options);
  result.three_point = static_cast<int>(metric.agreeing.size());
  if (result.three_point < options.least_inliers) return refused(result, "three_point");

  constexpr double kGather = 3.0;
  const auto refined = refine_pose(a, b, matches, metric.T_C_D, kGather * options.ransac_direction);
  if (!refined) return refused(result, "inliers");
  result.inliers = static_cast<int>(refined->agreeing.size());
  if (result.inliers < options.least_inliers) return refused(result, "inliers");
  if (result.inliers < options.least_share * result.matches) return refused(result, "share");
  if (!are_spread(a, b, refined->agreeing, options.least_spread)) return refused(result, "spread");
  if (!is_certain(refined->covariance, options)) return refused(result, "sigma");
  if (refined->T_C_D.translation.norm() > options.most_distance_m) return refused(result, "distance");

  const Overlap overlap =
      overlap_of(a, b, refined->T_C_D, kGather * options.ransac_direction, options.match.most_distance);
  result.overlap = overlap.share();
  if (result.overlap < options.least_overlap) return refused(result, "overlap");

  result.T_A_B = a.T_B_C * refined->T_C_D * b.T_B_C.inverse();
  const Matrix6d Ad = b.T_B_C.adjoint();
  result.covariance = Ad * refined->covariance * Ad.transpose() + floor_of(options);
  return result;
}

}  // namespace covey::place
