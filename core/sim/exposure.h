// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What an exposure makes of the light beside noise: a lens lets less through towards the corners, automatic exposure lets all pictures grow
// darker and brighter, and what moves while the shutter is open is smeared.

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/camera.h"

namespace covey::sim {

struct ExposureOptions {
  double vignette = 0.0;   // share of the light that a corner loses; it grows with the square of the distance
  double stops = 0.0;      // by how much pictures grow brighter and darker, in powers of two
  double period_s = 15.0;  // of that
  double open_s = 0.0;     // the shutter, around the picture's stamp
  int steps = 5;           // pictures that are averaged over that time
};

class Exposure {
 public:
  Exposure(const PinholeCamera& camera, const ExposureOptions& options, std::uint64_t seed);

  // Vignette and brightness at that time; what leaves 0 ... 255 is clipped.
  void apply(Utime utime, std::span<std::uint8_t> picture) const;

 private:
  ExposureOptions options_;
  double phase_;
  std::vector<float> shares_;  // of the light, by pixel; empty: all of it
};

// When the shutter is open: one time, or several in even steps.
std::vector<Utime> open_times(const ExposureOptions& options, Utime utime);

}  // namespace covey::sim
