// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Puts a MeshWorld together from textures and from quads, boxes, prisms and blobs of one material each. Light from the sky is part of
// the tint: faces differ in brightness by where they look.

#include <Eigen/Geometry>
#include <array>
#include <span>

#include "core/sim/canvas.h"
#include "core/sim/labels.h"
#include "core/sim/mesh_world.h"

namespace covey::sim {

struct Material {
  int layer = 0;
  Label label = Label::kGround;
  double metres = 1.0;  // side of the texture where it is laid on by length
  viewer::Rgb tint = {255, 255, 255};
};

class MeshBuilder {
 public:
  MeshBuilder(std::string name, int texture_side);

  // The number of the layer.
  int add_texture(const Canvas& canvas);

  // Corners counter-clockwise seen from the free side, beginning at the patch's top left.
  void quad(const std::array<Eigen::Vector3d, 4>& corners_W, const Patch& patch, const Material& material);
  // The texture is laid on by length along the corner 0 - corner 1 direction.
  void quad(const std::array<Eigen::Vector3d, 4>& corners_W, const Material& material);
  void triangle(const std::array<Eigen::Vector3d, 3>& corners_W, const Material& material);
  // On the ground, seen from above; the texture is laid on by W's coordinates, shifted by `shift` of its side.
  void ground(const Eigen::AlignedBox2d& box_W, double z, const Material& material,
              const Eigen::Vector2d& shift);

  // A box with a pose, from `low` to `high` in its own axes. Sides take `side`, the top takes `top`; there is no bottom unless it is
  // above the ground.
  void box(const Eigen::Isometry3d& T_W_X, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
           const Material& side, const Material& top);
  // Around a vertical axis, open at both ends; radii at z_low and z_high.
  void prism(const Eigen::Vector3d& foot_W, double height, double radius_low, double radius_high, int sides,
             const Material& material);
  // A lumpy ball: an icosahedron with each face cut in four and its vertices moved in and out by up to `lumps` of the radius.
  void blob(Random& random, const Eigen::Vector3d& centre_W, const Eigen::Vector3d& radii, double lumps,
            const Material& material);

  MeshWorld& world() { return world_; }

 private:
  std::uint32_t vertex(const Eigen::Vector3d& p_W, const Eigen::Vector2d& uv, const Material& material,
                       const viewer::Rgb& tint);
  viewer::Rgb lit(const viewer::Rgb& tint, const Eigen::Vector3d& normal_W) const;

  MeshWorld world_;
  std::vector<Paint> means_;  // per layer
};

}  // namespace covey::sim
