// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/mesh_score.h"

#include <algorithm>
#include <cmath>

namespace covey {
namespace {

DistanceScore summarise(std::vector<double> distances, double per_m2) {
  DistanceScore score;
  score.samples = static_cast<int>(distances.size());
  score.per_m2 = per_m2;
  if (distances.empty()) return score;
  const double n = static_cast<double>(distances.size());
  double squares = 0.0;
  std::array<int, 3> near = {};
  for (const double d : distances) {
    score.mean_m += d / n;
    squares += d * d;
    for (std::size_t k = 0; k < kWithinM.size(); ++k) near[k] += d <= kWithinM[k] ? 1 : 0;
  }
  score.rms_m = std::sqrt(squares / n);
  for (std::size_t k = 0; k < kWithinM.size(); ++k) score.within[k] = near[k] / n;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  score.median_m = *middle;
  return score;
}

}  // namespace

double samples_per_m2(const Surface& surface, const MeshScoreOptions& options) {
  return std::min(options.samples_per_m2, options.most_samples / std::max(surface.area_m2(), 1e-9));
}

MeshScore score_mesh(const Surface& estimate, const Surface& reference,
                     const std::vector<SurfacePoint>& reference_samples, double seen,
                     const MeshScoreOptions& options) {
  MeshScore score;
  score.seen = seen;
  std::vector<double> distances;
  int right = 0;
  int labelled = 0;
  const double per_m2 = samples_per_m2(estimate, options);
  for (const SurfacePoint& sample : estimate.sample(per_m2)) {
    const NearestPoint nearest = reference.nearest(sample.p);
    distances.push_back(nearest.distance_m);
    if (nearest.point.label >= viewer::kFirstNoLabel) continue;
    ++score.compared;
    labelled += sample.label < viewer::kFirstNoLabel ? 1 : 0;
    right += sample.label == nearest.point.label ? 1 : 0;
  }
  score.error = summarise(std::move(distances), per_m2);
  if (score.compared > 0) {
    score.labels = static_cast<double>(right) / score.compared;
    score.labelled = static_cast<double>(labelled) / score.compared;
  }
  distances.clear();
  for (const SurfacePoint& sample : reference_samples)
    distances.push_back(estimate.nearest(sample.p).distance_m);
  score.completeness = summarise(std::move(distances), samples_per_m2(reference, options));
  return score;
}

}  // namespace covey
