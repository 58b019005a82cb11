// SPDX-License-Identifier: BSD-3-Clause
#include <numbers>
#include <vector>

#include "core/sim/mesh_builder.h"
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
constexpr int kPosterSheets = 6;

struct Palette {
  int parquet, ceiling, steel;
  std::array<int, 4> wallpaper;
  std::array<int, 3> wood;
  std::array<int, 4> carton;
  std::array<int, 6> books;
  std::array<int, kPosterSheets> posters;
};

class Room {
 public:
  explicit Room(const RoomOptions& options)
      : random_(mix_seeds(options.seed, 0)),
        builder_("euroc-v1", options.texture_side),
        palette_(paint(options)) {}

  MeshWorld build() {
    shell();
    for (int wall = 0; wall < 4; ++wall) {
      hang_posters(wall);
      furnish(wall);
    }
    cover_floor();
    lamps();
    return std::move(builder_.world());
  }

 private:
  Palette paint(const RoomOptions& options) {
    std::uint64_t number = 0;
    const auto add = [&](const auto& painter) {
      Random random(mix_seeds(options.seed, ++number));
      return builder_.add_texture(painter(options.texture_side, random));
    };
    Palette palette = {};
    palette.parquet = add(paint_parquet);
    palette.ceiling = add(paint_tiles);
    palette.steel = add(paint_steel);
    for (int& layer : palette.wallpaper) layer = add(paint_wallpaper);
    for (int& layer : palette.wood) layer = add(paint_wood);
    for (int& layer : palette.carton) layer = add(paint_carton);
    for (int& layer : palette.books) layer = add(paint_books);
    for (int& layer : palette.posters) layer = add(paint_posters);
    return palette;
  }

  template <std::size_t N>
  Material any(const std::array<int, N>& layers, Label label, double metres) {
    return {layers[static_cast<std::size_t>(random_.below(N))], label, metres, tint()};
  }
  viewer::Rgb tint() {
    const auto channel = [&] { return static_cast<std::uint8_t>(random_.uniform(190.0, 255.0)); };
    return {channel(), channel(), channel()};
  }

  // Where wall number `wall` begins, looking at it from inside: x along it to the right, y out of the room through it, z up.
  Isometry3d wall_pose(int wall) const {
    const std::array<Vector3d, 4> corners = {
        Vector3d(kLow.x(), kHigh.y(), 0), Vector3d(kHigh.x(), kHigh.y(), 0), Vector3d(kHigh.x(), kLow.y(), 0),
        Vector3d(kLow.x(), kLow.y(), 0)};
    return Eigen::Translation3d(corners[static_cast<std::size_t>(wall)]) *
           Eigen::AngleAxisd(-0.5 * std::numbers::pi * wall, Vector3d::UnitZ());
  }
  double wall_length(int wall) const { return wall % 2 == 0 ? kHigh.x() - kLow.x() : kHigh.y() - kLow.y(); }

  void shell() {
    builder_.ground({kLow.head<2>(), kHigh.head<2>()}, 0.0,
                    {palette_.parquet, Label::kFloor, 2.0, {255, 255, 255}}, {0.0, 0.0});
    const auto corner = [&](bool x, bool y) {
      return Vector3d(x ? kHigh.x() : kLow.x(), y ? kHigh.y() : kLow.y(), kHigh.z());
    };
    builder_.quad({corner(false, false), corner(false, true), corner(true, true), corner(true, false)},
                  Material{palette_.ceiling, Label::kCeiling, 2.0, {255, 255, 255}});
    for (int wall = 0; wall < 4; ++wall) {
      const auto at = [&](double x, double z) { return Vector3d(wall_pose(wall) * Vector3d(x, 0.0, z)); };
      const double length = wall_length(wall);
      const double height = kHigh.z();
      builder_.quad({at(0, height), at(0, 0), at(length, 0), at(length, height)},
                    {palette_.wallpaper[static_cast<std::size_t>(wall)], Label::kWall, 2.5, {255, 255, 255}});
    }
  }

  Patch next_picture(int& layer) {
    const int number = pictures_++ % (kPosterSheets * kPostersOnSheet);
    layer = palette_.posters[static_cast<std::size_t>(number % kPosterSheets)];
    return poster_patch(number / kPosterSheets);
  }

  // Two rows on every wall, 1 cm proud of it.
  void hang_posters(int wall) {
    const Isometry3d T_W_wall = wall_pose(wall);
    for (const double row : {1.75, 3.1}) {
      for (double x = 0.25; x < wall_length(wall) - 1.2;) {
        const double width = random_.uniform(0.6, 1.15);
        const double height = random_.uniform(0.6, 1.1);
        const double bottom = row + random_.uniform(-0.35, 0.1) - 0.4 * height;
        const auto at = [&](double right, double up) {
          return Vector3d(T_W_wall * Vector3d(x + right, -0.01, bottom + up));
        };
        int layer = 0;
        const Patch patch = next_picture(layer);
        builder_.quad({at(0, height), at(0, 0), at(width, 0), at(width, height)}, patch,
                      {layer, Label::kWall, 1.0, tint()});
        x += width + random_.uniform(0.15, 0.7);
      }
    }
  }

  // Along a wall, from left to right: shelves, tables with boxes and a chair, stacks of boxes.
  void furnish(int wall) {
    for (double x = 0.9; x < wall_length(wall) - 2.2;) {
      const int kind = random_.below(3);
      const double width = kind == 0 ? 1.2 : kind == 1 ? random_.uniform(1.2, 1.7) : 0.7;
      const Isometry3d T_W_F = wall_pose(wall) * Eigen::Translation3d(x, 0.0, 0.0);
      if (kind == 0) {
        shelf(T_W_F, width);
      } else if (kind == 1) {
        table(T_W_F, width);
      } else {
        stack(T_W_F, width);
      }
      x += width + random_.uniform(0.1, 0.6);
    }
  }

  void box(const Isometry3d& T_W_F, const Vector3d& low, const Vector3d& high, const Material& material) {
    builder_.box(T_W_F, low, high, material, material);
  }

  void shelf(const Isometry3d& T_W_F, double width) {
    const Material wood = any(palette_.wood, Label::kShelf, 1.0);
    const double height = random_.uniform(1.3, 2.2);
    box(T_W_F, {0.0, -0.38, 0.0}, {width, -0.01, height}, wood);
    const auto at = [&](double x, double z) { return Vector3d(T_W_F * Vector3d(x, -0.385, z)); };
    builder_.quad(
        {at(0.03, height - 0.03), at(0.03, 0.06), at(width - 0.03, 0.06), at(width - 0.03, height - 0.03)},
        {0.0, 0.0, 1.0, height / 1.2}, any(palette_.books, Label::kShelf, 1.2));
  }

  void table(const Isometry3d& T_W_F, double width) {
    const Material wood = any(palette_.wood, Label::kTable, 1.0);
    const double depth = 0.75;
    box(T_W_F, {0.0, -depth, 0.70}, {width, -0.05, 0.75}, wood);
    for (const double x : {0.03, width - 0.09}) {
      for (const double y : {-depth + 0.03, -0.11}) box(T_W_F, {x, y, 0.0}, {x + 0.06, y + 0.06, 0.70}, wood);
    }
    for (double x = 0.08; x < width - 0.4;) {
      const double size = random_.uniform(0.18, 0.34);
      box(T_W_F, {x, -0.65, 0.75},
          {x + size, -0.65 + random_.uniform(0.2, 0.5), 0.75 + random_.uniform(0.12, 0.4)},
          any(palette_.carton, Label::kBox, size));
      x += size + random_.uniform(0.05, 0.3);
    }
    chair(T_W_F * Eigen::Translation3d(0.5 * width, -depth - 0.1, 0.0) *
          Eigen::AngleAxisd(random_.uniform(-0.4, 0.4), Vector3d::UnitZ()));
  }

  // Low, since the vehicles pass above it.
  void chair(const Isometry3d& T_W_F) {
    const Material wood = any(palette_.wood, Label::kChair, 1.0);
    const double half = 0.19;
    box(T_W_F, {-half, -half, 0.40}, {half, half, 0.44}, wood);
    box(T_W_F, {-half, -half, 0.44}, {half, -half + 0.03, 0.85}, any(palette_.books, Label::kChair, 0.8));
    for (const double x : {-half, half - 0.04}) {
      for (const double y : {-half, half - 0.04}) box(T_W_F, {x, y, 0.0}, {x + 0.04, y + 0.04, 0.40}, wood);
    }
  }

  void stack(const Isometry3d& T_W_F, double width) {
    double z = 0.0;
    const int boxes = 2 + random_.below(3);
    for (int i = 0; i < boxes; ++i) {
      const double height = random_.uniform(0.3, 0.5);
      const double half = 0.5 * width - random_.uniform(0.02, 0.14);
      const Isometry3d T_W_X = T_W_F * Eigen::Translation3d(0.5 * width, -0.55, z) *
                               Eigen::AngleAxisd(random_.uniform(-0.2, 0.2), Vector3d::UnitZ());
      box(T_W_X, {-half, -half, 0.0}, {half, half, height}, any(palette_.carton, Label::kBox, 2.0 * half));
      z += height;
    }
  }

  // Rugs and flat boxes in the middle.
  void cover_floor() {
    const std::array<Vector2d, 5> places = {
        Vector2d(-1.6, -1.8), {1.3, -1.2}, {-0.9, 0.7}, {1.4, 1.9}, {-1.7, 2.9}};
    for (const Vector2d& place : places) {
      const Isometry3d T_W_F = Eigen::Translation3d(place.x(), place.y(), 0.0) *
                               Eigen::AngleAxisd(random_.uniform(-0.6, 0.6), Vector3d::UnitZ());
      const double x = random_.uniform(0.6, 1.0);
      const double y = random_.uniform(0.5, 0.8);
      const auto at = [&](double right, double up) { return Vector3d(T_W_F * Vector3d(right, up, 0.008)); };
      int layer = 0;
      const Patch patch = next_picture(layer);
      builder_.quad({at(-x, y), at(-x, -y), at(x, -y), at(x, y)}, patch, {layer, Label::kFloor, 1.0, tint()});
      const double half = random_.uniform(0.15, 0.3);
      box(T_W_F * Eigen::Translation3d(random_.uniform(-0.3, 0.3), 0.2, 0.0), {-half, -half, 0.0},
          {half, half, random_.uniform(0.1, 0.22)}, any(palette_.carton, Label::kBox, 2.0 * half));
    }
  }

  void lamps() {
    for (const double x : {-2.0, 2.0}) {
      for (const double y : {-2.2, 0.6, 3.4}) {
        const Material steel = {palette_.steel, Label::kCeiling, 1.0, tint()};
        const Isometry3d T_W_L = Isometry3d(Eigen::Translation3d(x, y, kHigh.z()));
        box(T_W_L, {-0.6, -0.12, -0.12}, {0.6, 0.12, -0.04}, steel);
      }
    }
  }

  Random random_;
  MeshBuilder builder_;
  Palette palette_;
  int pictures_ = 0;
};

}  // namespace

MeshWorld make_room(const RoomOptions& options) { return Room(options).build(); }

}  // namespace covey::sim
