// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What is kept of a keyframe's images to find and measure a loop closure: points of the left camera with their descriptors and,
// where stereo, a depth camera or anything else gave one, their depth. Element k of each vector belongs to point k; the best come
// first: strong ones, spread over the picture.

#include <Eigen/Geometry>
#include <vector>

#include "core/geometry/se3.h"
#include "core/place/descriptor.h"

namespace covey::place {

// How exactly a camera sees.
struct ViewNoise {
  double direction = 0.003;      // std dev on the plane z = 1: px / focal
  double inverse_depth = 0.006;  // std dev, 1 / m: px / (focal * baseline)
};

struct FrameFeatures {
  std::vector<Eigen::Vector3f> bearings_C;  // unit vectors, z > 0
  std::vector<float> depths_m;              // along the optical axis; 0: unknown
  std::vector<Descriptor> descriptors;
  SE3 T_B_C;  // left camera in the body
  ViewNoise noise;

  std::size_t size() const { return descriptors.size(); }
  bool has_depth(std::size_t k) const { return depths_m[k] > 0.0F; }
  // On the plane z = 1.
  Eigen::Vector2d direction(std::size_t k) const { return bearings_C[k].cast<double>().hnormalized(); }
  Eigen::Vector3d point(std::size_t k) const {
    return static_cast<double>(depths_m[k]) * Eigen::Vector3d(direction(k).homogeneous());
  }
};

// The best `most`: those with a depth before those without, otherwise in their order; without the best `known`.
FrameFeatures best_of(const FrameFeatures& features, int most, int known = 0);

}  // namespace covey::place
