// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a lens makes of an ideal picture: the pinhole view that covers all that a distorted camera sees, and for each of its pixels the
// place in that view from which it comes.

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/camera.h"

namespace covey::sim {

class Lens {
 public:
  // `scale`: pixels of the ideal view to one of the camera's, at the picture's middle. InputError where the distortion folds over inside
  // of the picture.
  Lens(const PinholeCamera& camera, double scale);

  const PinholeCamera& camera() const { return camera_; }
  const PinholeCamera& ideal() const { return ideal_; }  // without distortion
  // Bilinear; grey pictures of the ideal camera's and of the camera's size.
  void distort(std::span<const std::uint8_t> ideal_view, std::span<std::uint8_t> picture) const;

 private:
  // Upper left of the four ideal pixels around a place, and how far to go to the right and down, in 1 / 256.
  struct Source {
    std::uint32_t pixel;
    std::uint16_t right;
    std::uint16_t down;
  };

  PinholeCamera camera_;
  PinholeCamera ideal_;
  std::vector<Source> sources_;
};

}  // namespace covey::sim
