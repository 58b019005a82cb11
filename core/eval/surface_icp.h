// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Iterated closest points: the small rigid motion that takes samples of a mesh nearer to a reference's surface. Each step
// aligns the samples with their nearest points within a distance. Source: Besl and McKay, "A method for registration of 3-D
// shapes", PAMI 1992.

#include "core/eval/surface.h"
#include "core/geometry/se3.h"

namespace covey {

struct IcpOptions {
  double within_m = 0.5;  // pairs further apart are left out
  int max_iterations = 30;
  double least_motion_m = 1e-4;  // of the samples' mean, and in radians times 10 m
  int most_samples = 20'000;
};

struct IcpResult {
  SE3 T_reference_estimate;  // after which the estimate lies better
  int iterations = 0;
  double rms_m = 0.0;  // of the last pairs
  int pairs = 0;
};

IcpResult align_surface(const Surface& estimate, const Surface& reference, const IcpOptions& options = {});

}  // namespace covey
