// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <numbers>
#include <utility>
#include <vector>

#include "core/sim/furnished_world.h"
#include "core/sim/mesh_world.h"
#include "core/sim/surfaces.h"

namespace covey::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kColumns = 4;  // of rooms on either side of the corridor
constexpr double kPitch = 6.6;
constexpr double kDepth = 6.0;     // of a room, with its wall to the corridor
constexpr double kCorridor = 1.2;  // half its width
constexpr double kHeight = 2.8;
constexpr double kWall = 0.2;
constexpr double kDoor = 0.65;  // half its width
constexpr double kLintel = 2.1;
// One drives around the middle of a room.
constexpr double kRingX = 1.55;
constexpr double kRingNear = 1.75;
constexpr double kRingFar = 4.4;

// How each room is furnished, in order: rooms of one number are alike.
constexpr std::array<int, 2 * kColumns> kFurnishing = {0, 1, 2, 0, 1, 3, 0, 4};

// Its frame: on the floor in the middle of its door at the corridor; y into the room, z up.
Isometry3d room_pose(int room) {
  const bool south = room >= kColumns;
  return Translation3d((room % kColumns + 0.5) * kPitch, south ? -kCorridor : kCorridor, 0.0) *
         Eigen::AngleAxisd(south ? std::numbers::pi : 0.0, Vector3d::UnitZ());
}

Eigen::AlignedBox3d floor_box() {
  return {Vector3d(0.0, -kCorridor - kDepth, 0.0), Vector3d(kColumns * kPitch, kCorridor + kDepth, kHeight)};
}

// A wall as WalledWorld has them, and where its door is, if any.
struct Wall {
  Isometry3d T_W_wall;
  double length = 0.0;
  double door_at = -1.0;  // its middle
};

class Rooms : private FurnishedWorld {
 public:
  explicit Rooms(const RoomsOptions& options)
      : FurnishedWorld({"rooms", options.seed, options.texture_side, floor_box(), 190.0}),
        seed_(options.seed),
        floor_(paint(paint_parquet)),
        ceiling_(paint(paint_tiles)),
        steel_(paint(paint_steel)) {
    for (int& layer : wallpaper_) layer = paint(paint_wallpaper);
    for (int& layer : doors_) layer = paint(paint_planks);
    paint_furniture();
    paint_pictures();
  }

  MeshWorld build() {
    lay_floor_and_ceiling(floor_, ceiling_, 2.0);
    for (int room = 0; room < 2 * kColumns; ++room) furnish_room(room);
    corridor();
    lay_roads();
    return std::move(builder().world());
  }

 private:
  Wall wall_of(int room, int wall) const {
    const double side = 0.5 * (kPitch - kWall);
    const std::array<Vector2d, 4> corners = {
        Vector2d(-side, kDepth), {side, kDepth}, {side, kWall}, {-side, kWall}};
    const Vector2d& begin = corners[static_cast<std::size_t>(wall)];
    const double length = (corners[static_cast<std::size_t>((wall + 1) % 4)] - begin).norm();
    return {room_pose(room) * Translation3d(begin.x(), begin.y(), 0.0) *
                Eigen::AngleAxisd(-0.5 * std::numbers::pi * wall, Vector3d::UnitZ()),
            length, wall == 2 ? 0.5 * length : -1.0};
  }

  // Wallpaper begins anywhere: nothing of it is where it is in another room.
  void panel(const Wall& wall, double from, double to, double low, double high, int layer) {
    const auto at = [&](double x, double z) { return Vector3d(wall.T_W_wall * Vector3d(x, 0.0, z)); };
    constexpr double kMetres = 2.5;
    const double u = random().uniform(0.0, 1.0);
    const double v = random().uniform(0.0, 1.0);
    builder().quad({at(from, high), at(from, low), at(to, low), at(to, high)},
                   {u, v, (to - from) / kMetres, (high - low) / kMetres},
                   {layer, Label::kWall, kMetres, {255, 255, 255}});
  }

  void paper(const Wall& wall, int layer) {
    if (wall.door_at < 0.0) return panel(wall, 0.0, wall.length, 0.0, kHeight, layer);
    panel(wall, 0.0, wall.door_at - kDoor, 0.0, kHeight, layer);
    panel(wall, wall.door_at + kDoor, wall.length, 0.0, kHeight, layer);
    panel(wall, wall.door_at - kDoor, wall.door_at + kDoor, kLintel, kHeight, layer);
  }

  // What one sees of the wall's thickness in a door.
  void frame(int room) {
    const Isometry3d T_W_R = room_pose(room);
    const auto at = [&](double x, double y, double z) { return Vector3d(T_W_R * Vector3d(x, y, z)); };
    const Material wood = any(doors_, Label::kWall, 1.8);
    builder().quad(
        {at(-kDoor, 0, kLintel), at(-kDoor, 0, 0), at(-kDoor, kWall, 0), at(-kDoor, kWall, kLintel)}, wood);
    builder().quad({at(kDoor, kWall, kLintel), at(kDoor, kWall, 0), at(kDoor, 0, 0), at(kDoor, 0, kLintel)},
                   wood);
    builder().quad({at(-kDoor, 0, kLintel), at(-kDoor, kWall, kLintel), at(kDoor, kWall, kLintel),
                    at(kDoor, 0, kLintel)},
                   wood);
  }

  bool is_at_door(const Wall& wall, double from, double to) const {
    return wall.door_at >= 0.0 && to > wall.door_at - kDoor - 0.1 && from < wall.door_at + kDoor + 0.1;
  }

  void hang_pictures(const Wall& wall, double sparsest) {
    for (double x = random().uniform(0.2, 0.8); x < wall.length - 1.2;) {
      const double width = random().uniform(0.6, 1.1);
      const double tall = random().uniform(0.6, 1.0);
      const double bottom = random().uniform(1.0, 1.6);
      if (!is_at_door(wall, x, x + width)) hang_picture(wall.T_W_wall, 0.01, x, bottom, width, tall);
      x += width + random().uniform(0.3, sparsest);
    }
  }

  void furnish_room(int room) {
    random_of_own_ = Random(mix_seeds(seed_, 1000 + static_cast<std::uint64_t>(room)));
    const int furnishing = kFurnishing[static_cast<std::size_t>(room)];
    random() = Random(mix_seeds(seed_, 2000 + static_cast<std::uint64_t>(furnishing)));
    const int layer = wallpaper_[static_cast<std::size_t>(furnishing)];
    for (int wall = 0; wall < 4; ++wall) furnish(wall_of(room, wall));
    island(room);
    std::swap(random(), random_of_own_);
    for (int wall = 0; wall < 4; ++wall) {
      paper(wall_of(room, wall), layer);
      hang_pictures(wall_of(room, wall), 2.0);
    }
    frame(room);
    lamp(room_pose(room) * Translation3d(0.0, 0.5 * (kRingNear + kRingFar), kHeight));
  }

  // Where the plan has a thing to stand, but a hand's breadth off: nobody measures.
  Isometry3d about(const Isometry3d& T_W_wall, double x) {
    return T_W_wall * Translation3d(x + random_of_own_.uniform(-0.12, 0.12), 0.0, 0.0);
  }

  // What it is and how it looks is the same in rooms that are alike; what lies on the tables, and stacks, are of this room.
  void furnish(const Wall& wall) {
    for (double x = 0.9; x < wall.length - 2.2;) {
      const int kind = random().below(5);
      const double width = kind < 2 ? 1.2 : kind < 4 ? random().uniform(1.2, 1.7) : 0.7;
      const Isometry3d T_W_F = about(wall.T_W_wall, x);
      if (wall.door_at >= 0.0 && x < wall.door_at + kDoor + 0.3 && x + width > wall.door_at - kDoor - 0.3) {
        x = wall.door_at + kDoor + 0.3;
        continue;
      }
      if (kind < 2) {
        shelf(T_W_F, width);
      } else if (kind < 4) {
        desk_with_things(T_W_F, width);
      } else {
        std::swap(random(), random_of_own_);
        stack(T_W_F, width);
        std::swap(random(), random_of_own_);
      }
      x += width + random().uniform(0.25, 0.8);
    }
  }

  void desk_with_things(const Isometry3d& T_W_F, double width) {
    desk(T_W_F, width);
    std::swap(random(), random_of_own_);
    lay_things(T_W_F, width);
    std::swap(random(), random_of_own_);
    pull_up_chair(T_W_F, width);
  }

  void island(int room) {
    const double width = random().uniform(1.2, 1.5);
    const double yaw = random_of_own_.uniform(-0.1, 0.1);
    desk_with_things(room_pose(room) * Translation3d(0.0, 0.5 * (kRingNear + kRingFar), 0.0) *
                         Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * Translation3d(-0.5 * width, 0.55, 0.0),
                     width);
  }

  void lamp(const Isometry3d& T_W_L) {
    box(T_W_L, {-0.6, -0.12, -0.12}, {0.6, 0.12, -0.04}, {steel_, Label::kCeiling, 1.0, tint()});
  }

  void corridor() {
    random() = Random(mix_seeds(seed_, 3000));
    for (int room = 0; room < 2 * kColumns; ++room) {
      const Wall wall{room_pose(room) * Translation3d(-0.5 * kPitch, 0.0, 0.0), kPitch, 0.5 * kPitch};
      paper(wall, wallpaper_.back());
      hang_pictures(wall, 1.2);
      if (random().chance(0.6))
        shelf(wall.T_W_wall * Translation3d(random().uniform(0.2, 1.1), 0.0, 0.0), 1.2);
    }
    for (const bool east : {false, true}) {
      const Wall wall{
          Translation3d(east ? kColumns * kPitch : 0.0, east ? kCorridor : -kCorridor, 0.0) *
              Eigen::AngleAxisd(east ? -0.5 * std::numbers::pi : 0.5 * std::numbers::pi, Vector3d::UnitZ()),
          2.0 * kCorridor};
      paper(wall, wallpaper_.back());
      hang_pictures(wall, 0.4);
    }
    for (int column = 0; column < kColumns; ++column)
      lamp(Isometry3d(Translation3d((column + 0.5) * kPitch, 0.0, kHeight)));
  }

  // Junctions: of the corridor before each pair of doors; of each room where its ring begins, then the ring's corners.
  void lay_roads() {
    RoadGraph& roads = builder().world().roads;
    roads.clear_half_width_m = 0.45;
    for (int column = 0; column < kColumns; ++column) {
      roads.junctions_W.emplace_back((column + 0.5) * kPitch, 0.0);
      if (column > 0) roads.roads.push_back({column - 1, column});
    }
    for (int room = 0; room < 2 * kColumns; ++room) {
      const int entry = static_cast<int>(roads.junctions_W.size());
      for (const Vector2d& place :
           {Vector2d(0.0, kRingNear), Vector2d(kRingX, kRingNear), Vector2d(kRingX, kRingFar),
            Vector2d(-kRingX, kRingFar), Vector2d(-kRingX, kRingNear)}) {
        const Vector3d p_W = room_pose(room) * Vector3d(place.x(), place.y(), 0.0);
        roads.junctions_W.emplace_back(p_W.head<2>());
      }
      roads.roads.push_back({room % kColumns, entry});
      for (int k = 0; k < 4; ++k) roads.roads.push_back({entry + k, entry + k + 1});
      roads.roads.push_back({entry, entry + 4});
    }
  }

  std::uint64_t seed_;
  int floor_;
  int ceiling_;
  int steel_;
  std::array<int, 6> wallpaper_ = {};  // one for each furnishing, and the corridor's
  std::array<int, 2> doors_ = {};
  Random random_of_own_{0};  // of what is this room's own
};

}  // namespace

std::vector<AlikeRooms> alike_rooms() {
  std::vector<AlikeRooms> alike;
  for (int a = 0; a < 2 * kColumns; ++a) {
    for (int b = a + 1; b < 2 * kColumns; ++b) {
      if (kFurnishing[static_cast<std::size_t>(a)] == kFurnishing[static_cast<std::size_t>(b)])
        alike.push_back({room_pose(a), room_pose(b)});
    }
  }
  return alike;
}

Eigen::AlignedBox3d rooms_inside() {
  const double side = 0.5 * (kPitch - kWall);
  return {Vector3d(-side, kWall, 0.0), Vector3d(side, kDepth, kHeight)};
}

MeshWorld make_rooms(const RoomsOptions& options) { return Rooms(options).build(); }

}  // namespace covey::sim
