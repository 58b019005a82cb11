// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/walled_world.h"

#include <numbers>

#include "core/sim/surfaces.h"

namespace covey::sim {

using Eigen::Isometry3d;
using Eigen::Vector3d;

WalledWorld::WalledWorld(const WalledWorldOptions& options)
    : random_(mix_seeds(options.seed, 0)), builder_(options.name, options.texture_side), options_(options) {}

void WalledWorld::paint_pictures() {
  for (int& layer : sheets_) layer = paint(paint_posters);
}

viewer::Rgb WalledWorld::tint() {
  const auto channel = [&] {
    return static_cast<std::uint8_t>(random_.uniform(options_.darkest_tint, 255.0));
  };
  return {channel(), channel(), channel()};
}

Isometry3d WalledWorld::wall_pose(int wall) const {
  const Vector3d& low = options_.box_W.min();
  const Vector3d& high = options_.box_W.max();
  const std::array<Vector3d, 4> corners = {
      Vector3d(low.x(), high.y(), low.z()), Vector3d(high.x(), high.y(), low.z()),
      Vector3d(high.x(), low.y(), low.z()), Vector3d(low.x(), low.y(), low.z())};
  return Eigen::Translation3d(corners[static_cast<std::size_t>(wall)]) *
         Eigen::AngleAxisd(-0.5 * std::numbers::pi * wall, Vector3d::UnitZ());
}

void WalledWorld::lay_floor_and_ceiling(int floor_layer, int ceiling_layer, double metres) {
  const Vector3d& low = options_.box_W.min();
  const Vector3d& high = options_.box_W.max();
  builder_.ground({low.head<2>(), high.head<2>()}, floor(),
                  {floor_layer, Label::kFloor, metres, {255, 255, 255}}, {0.0, 0.0});
  builder_.quad({Vector3d(low.x(), low.y(), high.z()), Vector3d(low.x(), high.y(), high.z()),
                 Vector3d(high.x(), high.y(), high.z()), Vector3d(high.x(), low.y(), high.z())},
                Material{ceiling_layer, Label::kCeiling, metres, {255, 255, 255}});
}

void WalledWorld::picture(const std::array<Vector3d, 4>& corners_W, Label label) {
  const int number = pictures_++ % (kPictureSheets * kPostersOnSheet);
  builder_.quad(corners_W, poster_patch(number / kPictureSheets),
                {sheets_[static_cast<std::size_t>(number % kPictureSheets)], label, 1.0, tint()});
}

void WalledWorld::hang_picture(const Isometry3d& T_W_wall, double proud, double x, double z, double width,
                               double height) {
  const auto at = [&](double right, double up) {
    return Vector3d(T_W_wall * Vector3d(x + right, -proud, z + up));
  };
  picture({at(0, height), at(0, 0), at(width, 0), at(width, height)}, Label::kWall);
}

}  // namespace covey::sim
