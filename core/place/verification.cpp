// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/verification.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/place/minimal_poses.h"
#include "core/place/overlap.h"
#include "core/place/point_spread.h"

namespace covey::place {
namespace {

// Null where the points fill the picture and space.
const char* degenerate(const PointSpread& spread, const VerificationOptions& options) {
  constexpr double kLong = 2.0;  // times least_spread: what is narrow and not even that long is a corner
  if (spread.across < options.least_spread)
    return spread.along < kLong * options.least_spread ? "corner" : "line";
  return spread.thickness < options.least_thickness ? "plane" : nullptr;
}

double largest_variance(const Eigen::Matrix3d& covariance) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvalues().maxCoeff();
}

bool is_certain(const Matrix6d& covariance, const VerificationOptions& options) {
  const double position = std::sqrt(largest_variance(covariance.topLeftCorner<3, 3>()));
  const double angle = std::sqrt(largest_variance(covariance.bottomRightCorner<3, 3>()));
  return position <= options.most_sigma_m && angle <= options.most_sigma_deg * kDegree;
}

// What the residuals say, with the correlation of neighbouring points' errors, and what calibration may be off.
Matrix6d honest_covariance(const RefinedPose& refined, const VerificationOptions& options) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(refined.T_C_D.translation.squaredNorm()),
      Eigen::Vector3d::Constant(refined.T_C_D.rotation.log().squaredNorm());
  Matrix6d covariance = options.correlation * refined.variance_factor * refined.covariance;
  covariance.diagonal() += std::pow(options.calibration, 2) * variances;
  return covariance;
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
  const PointSpread spread = spread_of(a, b, refined->agreeing, refined->T_C_D);
  if (const char* why = degenerate(spread, options)) return refused(result, why);
  const Matrix6d covariance = honest_covariance(*refined, options);
  if (!is_certain(covariance, options)) return refused(result, "sigma");
  if (refined->T_C_D.translation.norm() > options.most_distance_m) return refused(result, "distance");

  const Overlap overlap =
      overlap_of(a, b, refined->T_C_D, kGather * options.ransac_direction, options.match.most_distance);
  result.overlap = overlap.share();
  if (result.overlap < options.least_overlap) return refused(result, "overlap");

  result.T_A_B = a.T_B_C * refined->T_C_D * b.T_B_C.inverse();
  const Matrix6d Ad = b.T_B_C.adjoint();
  result.covariance = Ad * covariance * Ad.transpose();
  return result;
}

}  // namespace covey::place
