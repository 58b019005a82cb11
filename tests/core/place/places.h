// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Made-up places for tests: points in front of cameras, with descriptors, as two cameras see them.

#include <Eigen/Geometry>
#include <vector>

#include "core/place/features.h"
#include "tests/core/geometry/random.h"

namespace covey::place::testing {

using covey::testing::RandomGeometry;

inline Descriptor random_descriptor(RandomGeometry& random) {
  Descriptor descriptor{};
  for (std::size_t bit = 0; bit < kDescriptorBits; ++bit) {
    if (random.uniform(0.0, 1.0) < 0.5) descriptor[bit / 64] |= std::uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

// A few of its bits turned, as noise and another view do.
inline Descriptor disturbed(Descriptor descriptor, int bits, RandomGeometry& random) {
  for (int k = 0; k < bits; ++k) {
    const int bit = random.index(kDescriptorBits);
    descriptor[static_cast<std::size_t>(bit / 64)] ^= std::uint64_t{1} << (bit % 64);
  }
  return descriptor;
}

struct Landmark {
  Eigen::Vector3d p_W;
  Descriptor descriptor;
};

inline std::vector<Landmark> make_place(int landmarks, RandomGeometry& random) {
  std::vector<Landmark> place;
  for (int k = 0; k < landmarks; ++k) {
    place.push_back({{random.uniform(-6.0, 6.0), random.uniform(-3.0, 3.0), random.uniform(4.0, 15.0)},
                     random_descriptor(random)});
  }
  return place;
}

struct SeeOptions {
  double direction_sigma = 0.002;
  double inverse_depth_sigma = 0.004;
  double depth_share = 0.8;
  int turned_bits = 12;
  int strangers = 100;  // points of no place
  double far_m = 1e3;
};

inline void add_point(FrameFeatures& features, const Eigen::Vector3d& p_C, const Descriptor& descriptor,
                      const SeeOptions& options, RandomGeometry& random) {
  const Eigen::Vector2d direction = p_C.hnormalized() + random.vector<2>(options.direction_sigma);
  const double inverse_depth = 1.0 / p_C.z() + options.inverse_depth_sigma * random.normal();
  const bool has_depth = inverse_depth > 0.01 && random.uniform(0.0, 1.0) < options.depth_share;
  features.bearings_C.emplace_back(direction.homogeneous().normalized().cast<float>());
  features.depths_m.push_back(has_depth ? static_cast<float>(1.0 / inverse_depth) : 0.0F);
  features.descriptors.push_back(disturbed(descriptor, options.turned_bits, random));
}

inline FrameFeatures see(const std::vector<Landmark>& place, const SE3& T_W_B, const SE3& T_B_C,
                         RandomGeometry& random, const SeeOptions& options = {}) {
  FrameFeatures features;
  features.T_B_C = T_B_C;
  features.noise = {options.direction_sigma, options.inverse_depth_sigma};
  for (const Landmark& landmark : place) {
    const Eigen::Vector3d p_C = (T_W_B * T_B_C).inverse() * landmark.p_W;
    if (p_C.z() > 0.5 && p_C.z() < options.far_m && p_C.hnormalized().cwiseAbs().maxCoeff() < 0.8) {
      add_point(features, p_C, landmark.descriptor, options, random);
    }
  }
  for (int k = 0; k < options.strangers; ++k) {
    const Eigen::Vector3d p_C(random.uniform(-4.0, 4.0), random.uniform(-2.0, 2.0), random.uniform(4.0, 9.0));
    add_point(features, p_C, random_descriptor(random), options, random);
  }
  return features;
}

// A camera that looks forward from a body.
inline SE3 forward_camera() {
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {SO3::from_matrix(axes), {0.1, 0.1, 0.05}};
}
// The body that stands so that the camera is at the world's origin and looks along z.
inline SE3 body_behind_camera() { return forward_camera().inverse(); }

}  // namespace covey::place::testing
