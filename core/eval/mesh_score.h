// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// How well a mesh agrees with a reference that is in the same frame. Both are sampled evenly by area; a sample's distance is
// that to the other's nearest surface point.
//   error         from the estimate to the reference: how wrong is what is there
//   completeness  from the reference to the estimate: how much of it is missing; only of the reference that was seen, where
//                 that is known (seen_surface.h)
//   labels        share of the estimate's samples whose label is that of the reference's nearest point, among those where the
//                 reference has one; a sample without a label counts as wrong
// The paper (section VII) samples both, 1000 points a square metre, registers them by ICP and gives the mean distance from the
// reference's points to the estimate's, which a mesh with anything beside the surface passes as well.

#include <array>
#include <vector>

#include "core/eval/surface.h"

namespace covey {

struct MeshScoreOptions {
  double samples_per_m2 = 1000.0;  // at most
  int most_samples = 200'000;      // of either mesh: large ones are sampled less densely
};

struct DistanceScore {
  int samples = 0;
  double per_m2 = 0.0;
  double mean_m = 0.0;
  double median_m = 0.0;
  double rms_m = 0.0;
  std::array<double, 3> within = {};  // share within 5, 10, 20 cm
};
constexpr std::array<double, 3> kWithinM = {0.05, 0.10, 0.20};

struct MeshScore {
  DistanceScore error;
  DistanceScore completeness;
  double seen = 1.0;  // share of the reference's samples that completeness is of
  int compared = 0;   // samples with a label in the reference; 0: there is no `labels`
  double labels = 0.0;
  double labelled = 0.0;  // share of them that have a label in the estimate
};

double samples_per_m2(const Surface& surface, const MeshScoreOptions& options);

// `reference_samples` are those of completeness, all of them or those that were seen; `seen` is their share.
MeshScore score_mesh(const Surface& estimate, const Surface& reference,
                     const std::vector<SurfacePoint>& reference_samples, double seen,
                     const MeshScoreOptions& options = {});

}  // namespace covey
