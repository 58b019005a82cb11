// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What people put into rooms: shelves, tables with boxes and a chair, stacks of boxes, along the walls.

#include <Eigen/Geometry>
#include <array>

#include "core/sim/walled_world.h"

namespace covey::sim {

class FurnishedWorld : protected WalledWorld {
 protected:
  using WalledWorld::WalledWorld;

  void paint_furniture();

  // From where it stands at the wall: x along the wall to the right, y outwards through it, z up. Tables and shelves are `width` wide; they
  // reach 0.4 m into the room, tables with their chair 1.15 m, stacks 1.0 m.
  void shelf(const Eigen::Isometry3d& T_W_F, double width);
  // A bare table, what lies on it, and its chair; table() is all three.
  void desk(const Eigen::Isometry3d& T_W_F, double width);
  void lay_things(const Eigen::Isometry3d& T_W_F, double width);
  void pull_up_chair(const Eigen::Isometry3d& T_W_F, double width);
  void table(const Eigen::Isometry3d& T_W_F, double width);
  void stack(const Eigen::Isometry3d& T_W_F, double width);

  Material carton(double metres) { return any(carton_, Label::kBox, metres); }

 private:
  static constexpr double kTableDepth = 0.75;

  void chair(const Eigen::Isometry3d& T_W_F);

  std::array<int, 3> wood_ = {};
  std::array<int, 4> carton_ = {};
  std::array<int, 6> books_ = {};
};

}  // namespace covey::sim
