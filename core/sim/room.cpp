// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <vector>

#include "core/sim/furnished_world.h"
#include "core/sim/mesh_world.h"
#include "core/sim/surfaces.h"

namespace covey::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The room, in metres; the volume that must stay empty is room_flight_volume().
const Vector3d kLow(-4.2, -4.4, 0.0);
const Vector3d kHigh(4.1, 5.4, 4.0);

class Room : private FurnishedWorld {
 public:
  explicit Room(const RoomOptions& options)
      : FurnishedWorld({"euroc-v1", options.seed, options.texture_side, {kLow, kHigh}, 190.0}),
        parquet_(paint(paint_parquet)),
        ceiling_(paint(paint_tiles)),
        steel_(paint(paint_steel)) {
    for (int& layer : wallpaper_) layer = paint(paint_wallpaper);
    paint_furniture();
    paint_pictures();
  }

  MeshWorld build() {
    lay_floor_and_ceiling(parquet_, ceiling_, 2.0);
    for (int wall = 0; wall < 4; ++wall) paper(wall);
    for (int wall = 0; wall < 4; ++wall) {
      hang_pictures(wall);
      furnish(wall);
    }
    cover_floor();
    lamps();
    return std::move(builder().world());
  }

 private:
  void paper(int wall) {
    const auto at = [&](double x, double z) { return Vector3d(wall_pose(wall) * Vector3d(x, 0.0, z)); };
    const double length = wall_length(wall);
    builder().quad({at(0, height()), at(0, 0), at(length, 0), at(length, height())},
                   {wallpaper_[static_cast<std::size_t>(wall)], Label::kWall, 2.5, {255, 255, 255}});
  }

  // Two rows on every wall, 1 cm proud of it.
  void hang_pictures(int wall) {
    const Isometry3d T_W_wall = wall_pose(wall);
    for (const double row : {1.75, 3.1}) {
      for (double x = 0.25; x < wall_length(wall) - 1.2;) {
        const double width = random().uniform(0.6, 1.15);
        const double tall = random().uniform(0.6, 1.1);
        const double bottom = row + random().uniform(-0.35, 0.1) - 0.4 * tall;
        hang_picture(T_W_wall, 0.01, x, bottom, width, tall);
        x += width + random().uniform(0.15, 0.7);
      }
    }
  }

  // Along a wall, from left to right: shelves, tables with boxes and a chair, stacks of boxes.
  void furnish(int wall) {
    for (double x = 0.9; x < wall_length(wall) - 2.2;) {
      const int kind = random().below(3);
      const double width = kind == 0 ? 1.2 : kind == 1 ? random().uniform(1.2, 1.7) : 0.7;
      const Isometry3d T_W_F = wall_pose(wall) * Eigen::Translation3d(x, 0.0, 0.0);
      if (kind == 0) {
        shelf(T_W_F, width);
      } else if (kind == 1) {
        table(T_W_F, width);
      } else {
        stack(T_W_F, width);
      }
      x += width + random().uniform(0.1, 0.6);
    }
  }

  // Rugs and flat boxes in the middle.
  void cover_floor() {
    const std::array<Vector2d, 5> places = {
        Vector2d(-1.6, -1.8), {1.3, -1.2}, {-0.9, 0.7}, {1.4, 1.9}, {-1.7, 2.9}};
    for (const Vector2d& place : places) {
      const Isometry3d T_W_F = Eigen::Translation3d(place.x(), place.y(), 0.0) *
                               Eigen::AngleAxisd(random().uniform(-0.6, 0.6), Vector3d::UnitZ());
      const double x = random().uniform(0.6, 1.0);
      const double y = random().uniform(0.5, 0.8);
      const auto at = [&](double right, double up) { return Vector3d(T_W_F * Vector3d(right, up, 0.008)); };
      picture({at(-x, y), at(-x, -y), at(x, -y), at(x, y)}, Label::kFloor);
      const double half = random().uniform(0.15, 0.3);
      box(T_W_F * Eigen::Translation3d(random().uniform(-0.3, 0.3), 0.2, 0.0), {-half, -half, 0.0},
          {half, half, random().uniform(0.1, 0.22)}, carton(2.0 * half));
    }
  }

  void lamps() {
    for (const double x : {-2.0, 2.0}) {
      for (const double y : {-2.2, 0.6, 3.4}) {
        const Material steel = {steel_, Label::kCeiling, 1.0, tint()};
        const Isometry3d T_W_L = Isometry3d(Eigen::Translation3d(x, y, kHigh.z()));
        box(T_W_L, {-0.6, -0.12, -0.12}, {0.6, 0.12, -0.04}, steel);
      }
    }
  }

  int parquet_;
  int ceiling_;
  int steel_;
  std::array<int, 4> wallpaper_ = {};
};

}  // namespace

MeshWorld make_room(const RoomOptions& options) { return Room(options).build(); }

}  // namespace covey::sim
