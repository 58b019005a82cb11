// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/minimal_poses.h"

#include <cmath>
#include <memory>
#include <opengv/absolute_pose/CentralAbsoluteAdapter.hpp>
#include <opengv/relative_pose/CentralRelativeAdapter.hpp>
#include <opengv/sac/Ransac.hpp>
#include <opengv/sac_problems/absolute_pose/AbsolutePoseSacProblem.hpp>
#include <opengv/sac_problems/relative_pose/CentralRelativePoseSacProblem.hpp>

namespace covey::place {
namespace {

using RelativeProblem = opengv::sac_problems::relative_pose::CentralRelativePoseSacProblem;
using AbsoluteProblem = opengv::sac_problems::absolute_pose::AbsolutePoseSacProblem;

constexpr bool kSeedFromClock = false;
constexpr double kProbability = 0.99;

// OpenGV's measure of an error of direction: 1 - cos.
double one_minus_cos(double direction) { return 1.0 - std::cos(std::atan(direction)); }

Eigen::Vector3d bearing(const FrameFeatures& features, int k) {
  return features.bearings_C[static_cast<std::size_t>(k)].cast<double>().normalized();
}

template <typename Problem>
PoseHypothesis ransac(std::shared_ptr<Problem> problem, const Pairs& pairs, double threshold,
                      int iterations) {
  PoseHypothesis hypothesis;
  if (static_cast<int>(pairs.size()) < problem->getSampleSize()) return hypothesis;
  opengv::sac::Ransac<Problem> ransac(iterations, threshold, kProbability);
  ransac.sac_model_ = std::move(problem);
  if (!ransac.computeModel()) return hypothesis;
  for (const int k : ransac.inliers_) hypothesis.agreeing.push_back(pairs[static_cast<std::size_t>(k)]);
  Eigen::Matrix4d T_C_D = Eigen::Matrix4d::Identity();
  T_C_D.topRows<3>() = ransac.model_coefficients_;
  hypothesis.T_C_D = SE3::from_matrix(T_C_D);
  return hypothesis;
}

}  // namespace

PoseHypothesis five_point_ransac(const FrameFeatures& c, const FrameFeatures& d, const Pairs& pairs,
                                 double direction, int iterations) {
  opengv::bearingVectors_t in_c;
  opengv::bearingVectors_t in_d;
  for (const auto& [i, j] : pairs) {
    in_c.push_back(bearing(c, i));
    in_d.push_back(bearing(d, j));
  }
  opengv::relative_pose::CentralRelativeAdapter adapter(in_c, in_d);
  // The problem adds up both views' errors.
  return ransac(std::make_shared<RelativeProblem>(adapter, RelativeProblem::NISTER, kSeedFromClock), pairs,
                2.0 * one_minus_cos(direction), iterations);
}

PoseHypothesis three_point_ransac(const FrameFeatures& c, const FrameFeatures& d, const Pairs& pairs,
                                  double direction, int iterations) {
  opengv::bearingVectors_t in_d;
  opengv::points_t points_C;
  Pairs measured;
  for (const auto& [i, j] : pairs) {
    if (!c.has_depth(static_cast<std::size_t>(i))) continue;
    points_C.push_back(c.point(static_cast<std::size_t>(i)));
    in_d.push_back(bearing(d, j));
    measured.emplace_back(i, j);
  }
  opengv::absolute_pose::CentralAbsoluteAdapter adapter(in_d, points_C);
  return ransac(std::make_shared<AbsoluteProblem>(adapter, AbsoluteProblem::KNEIP, kSeedFromClock), measured,
                one_minus_cos(direction), iterations);
}

}  // namespace covey::place
