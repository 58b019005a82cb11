// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Geometric verification: are two keyframes of the same place, and where were they to each other? Section V of the paper:
//
//   descriptors matched (nearest neighbours with ratio test)
//   -> Nister's five points in RANSAC on the bearings: matches that no camera motion explains are left out
//   -> three points in RANSAC: the pose in metres. P3P (Kneip, CVPR 2011) on points with depth in one camera and bearings in the
//      other, instead of Arun's on points with depth in both: it needs no second depth, and no depth error enters twice
//   -> refinement with all views and depths of both cameras (pose_refinement.h), which gives the covariance
//   -> points in one corner of the picture, one line or one plane are refused (point_spread.h)
//   -> beyond the paper: what the pose foretells must be there (overlap.h), else two places only have a thing in common
//
// Both RANSACs are OpenGV's, with a fixed seed: the same features give the same result.

#include <cstddef>

#include "core/place/descriptor_matcher.h"
#include "core/place/features.h"
#include "core/place/pose_refinement.h"

namespace covey::place {

struct VerificationOptions {
  MatchOptions match{};
  double ransac_direction = 0.0065;  // a view this far off (on the plane z = 1) is no inlier: 3 px / focal
  int five_point_iterations = 150;
  int three_point_iterations = 300;
  int least_matches = 20;      // fewer are not worth a RANSAC: they end in none
  int least_inliers = 12;      // after every step, and in the end
  double least_share = 0.3;    // of the matches
  double least_spread = 0.08;  // std dev of the inliers' directions, in both images, along their shorter axis
  double least_thickness = 0.015;  // of the inliers in space, over their distance: below it they are a plane
  double most_sigma_m = 0.15;      // of the pose: worse is not worth having
  double most_sigma_deg = 1.5;
  double most_distance_m = 6.0;  // between the cameras: beyond that descriptors are not the same any more
  double least_overlap = 0.36;   // share of what the pose foretells that is found (overlap.h)
  // The covariance is that of the information times the residuals' variance factor, times this, since neighbouring corners err alike;
  // and the scale of the cameras' angles and depths is known to this share.
  double correlation = 1.4;
  double calibration = 0.002;
};

struct Verification {
  int matches = 0;
  int five_point = 0;
  int three_point = 0;
  int inliers = 0;
  double overlap = 0.0;
  // "matches", "five_point", "three_point", "inliers", "share", "corner", "line", "plane", "sigma", "distance", "overlap"
  const char* refused = nullptr;
  SE3 T_A_B;                               // of the bodies; where not refused
  Matrix6d covariance = Matrix6d::Zero();  // [rho; phi] in B
};

Verification verify(const FrameFeatures& a, const FrameFeatures& b, const VerificationOptions& options = {});

}  // namespace covey::place
