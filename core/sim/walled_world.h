// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What room and hall have in common: a box of floor, ceiling and four walls; surfaces that are painted from a seed; and pictures
// everywhere, no two alike until all sheets of them are used up.

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>

#include "core/sim/mesh_builder.h"
#include "core/sim/mesh_world.h"
#include "core/sim/random.h"

namespace covey::sim {

struct WalledWorldOptions {
  std::string name;
  std::uint64_t seed = 1;
  int texture_side = 512;
  Eigen::AlignedBox3d box_W;
  double darkest_tint = 185.0;  // 0 ... 255
};

class WalledWorld {
 protected:
  explicit WalledWorld(const WalledWorldOptions& options);

  // The layer of a new surface. Each has a seed of its own: to change one leaves the others as they are.
  template <typename Painter>
  int paint(const Painter& painter) {
    Random random(mix_seeds(options_.seed, ++painted_));
    return builder_.add_texture(painter(options_.texture_side, random));
  }
  void paint_pictures();

  template <std::size_t N>
  Material any(const std::array<int, N>& layers, Label label, double metres) {
    return {layers[static_cast<std::size_t>(random_.below(N))], label, metres, tint()};
  }
  viewer::Rgb tint();

  double floor() const { return options_.box_W.min().z(); }
  double height() const { return options_.box_W.sizes().z(); }
  const Eigen::AlignedBox3d& bounds() const { return options_.box_W; }  // in W
  // Where wall number `wall` begins, looking at it from inside: x along it to the right, y outwards through it, z up.
  Eigen::Isometry3d wall_pose(int wall) const;
  double wall_length(int wall) const { return options_.box_W.sizes()[wall % 2]; }

  void lay_floor_and_ceiling(int floor_layer, int ceiling_layer, double metres);
  void box(const Eigen::Isometry3d& T_W_F, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
           const Material& material) {
    builder_.box(T_W_F, low, high, material, material);
  }
  // The next one. Corners as those of MeshBuilder::quad.
  void picture(const std::array<Eigen::Vector3d, 4>& corners_W, Label label);
  // Its lower left corner at (x, z) of the wall, `proud` metres before it.
  void hang_picture(const Eigen::Isometry3d& T_W_wall, double proud, double x, double z, double width,
                    double height);

  Random& random() { return random_; }
  MeshBuilder& builder() { return builder_; }

 private:
  static constexpr int kPictureSheets = 6;

  Random random_;
  MeshBuilder builder_;
  WalledWorldOptions options_;
  std::uint64_t painted_ = 0;
  std::array<int, kPictureSheets> sheets_ = {};
  int pictures_ = 0;
};

}  // namespace covey::sim
