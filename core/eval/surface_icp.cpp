// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/surface_icp.h"

#include <algorithm>

#include "core/geometry/alignment.h"

namespace covey {

IcpResult align_surface(const Surface& estimate, const Surface& reference, const IcpOptions& options) {
  IcpResult result;
  const auto samples = estimate.sample(options.most_samples / std::max(estimate.area_m2(), 1e-9));
  while (result.iterations < options.max_iterations) {
    std::vector<Eigen::Vector3d> from;
    std::vector<Eigen::Vector3d> to;
    for (const SurfacePoint& sample : samples) {
      const Eigen::Vector3d p = result.T_reference_estimate * Eigen::Vector3d(sample.p.cast<double>());
      const NearestPoint nearest = reference.nearest(p.cast<float>());
      if (nearest.distance_m > options.within_m) continue;
      from.push_back(p);
      to.push_back(nearest.point.p.cast<double>());
    }
    result.pairs = static_cast<int>(from.size());
    if (result.pairs < 10) break;
    const Alignment step = align_points(from, to);
    result.T_reference_estimate = step.T_to_from * result.T_reference_estimate;
    result.rms_m = step.rms;
    ++result.iterations;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : from) mean += p / static_cast<double>(from.size());
    const double motion = (step.T_to_from * mean - mean).norm() + 10.0 * step.T_to_from.rotation.log().norm();
    if (motion < options.least_motion_m) break;
  }
  return result;
}

}  // namespace covey
