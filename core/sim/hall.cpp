// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.h"
#include "core/sim/mesh_world.h"
#include "core/sim/surfaces.h"
#include "core/sim/walled_world.h"

namespace covey::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWallsAway = 3.5;    // m, of the flights' outermost places
constexpr double kCeilingAway = 2.5;  // of the highest
constexpr double kFloorAway = 0.5;    // of the lowest
constexpr double kCell = 2.6;         // side of the squares of floor that may hold one thing each
constexpr double kTallest = 4.5;      // of what stands free
constexpr double kLowest = 0.25;      // lower things are not worth their place

AlignedBox3d box_around(const std::vector<Vector3d>& flown_W) {
  AlignedBox3d box;
  for (const Vector3d& place : flown_W) box.extend(place);
  box.min() -= Vector3d(kWallsAway, kWallsAway, kFloorAway);
  box.max() += Vector3d(kWallsAway, kWallsAway, kCeilingAway);
  return box;
}

class Hall : private WalledWorld {
 public:
  explicit Hall(const HallOptions& options)
      : WalledWorld({"euroc-mh", options.seed, options.texture_side, box_around(options.flown_W), 185.0}),
        options_(options),
        paving_(paint(paint_paving)),
        ceiling_(paint(paint_tiles)) {
    for (std::size_t k = 0; k < walls_.size(); ++k) {
      const Facade facade{.storeys = 2, .windows = 2 + static_cast<int>(k + 2) % 3, .has_door = false};
      walls_[k] = paint([&](int side, Random& random) { return paint_facade(side, random, facade); });
    }
    for (int& layer : steel_) layer = paint(paint_steel);
    for (int& layer : machines_) layer = paint(paint_bodywork);
    for (int& layer : carton_) layer = paint(paint_carton);
    for (int& layer : planks_) layer = paint(paint_planks);
    paint_pictures();
  }

  MeshWorld build() {
    lay_floor_and_ceiling(paving_, ceiling_, 3.0);
    for (int wall = 0; wall < 4; ++wall) clad(wall);
    for (int wall = 0; wall < 4; ++wall) hang_pictures(wall);
    beams();
    const double width = bounds().sizes().x() - 1.0;
    const double depth = bounds().sizes().y() - 1.0;
    const int columns = std::max(1, static_cast<int>(width / kCell));
    const int rows = std::max(1, static_cast<int>(depth / kCell));
    for (int column = 0; column < columns; ++column) {
      for (int row = 0; row < rows; ++row) {
        const Vector2d place(bounds().min().x() + 0.5 + (column + 0.5) * width / columns,
                             bounds().min().y() + 0.5 + (row + 0.5) * depth / rows);
        furnish(place);
      }
    }
    return std::move(builder().world());
  }

 private:
  // Bays of about 5 m, each with a front of its own.
  void clad(int wall) {
    const Isometry3d T_W_wall = wall_pose(wall);
    const int bays = std::max(1, static_cast<int>(std::lround(wall_length(wall) / 5.0)));
    const double width = wall_length(wall) / bays;
    const double storeys = height() / width;
    for (int bay = 0; bay < bays; ++bay) {
      const auto at = [&](double x, double z) { return Vector3d(T_W_wall * Vector3d(x, 0.0, z)); };
      const double left = bay * width;
      builder().quad({at(left, height()), at(left, 0), at(left + width, 0), at(left + width, height())},
                     {0.0, 1.0 - storeys, 1.0, storeys}, any(walls_, Label::kWall, width));
    }
  }

  // Signs in rows up the walls, 2 cm proud of them.
  void hang_pictures(int wall) {
    const Isometry3d T_W_wall = wall_pose(wall);
    for (double row = 0.6; row < height() - 1.6; row += 2.1) {
      for (double x = random().uniform(0.3, 1.2); x < wall_length(wall) - 1.6;) {
        const double width = random().uniform(0.7, 1.4);
        const double tall = random().uniform(0.7, 1.3);
        hang_picture(T_W_wall, 0.02, x, row + random().uniform(0.0, 0.5), width, tall);
        x += width + random().uniform(0.3, 1.6);
      }
    }
  }

  // Under the ceiling, across the hall.
  void beams() {
    const double top = bounds().max().z();
    for (double x = bounds().min().x() + 1.5; x < bounds().max().x() - 1.0; x += 3.0) {
      box(Isometry3d::Identity(), {x, bounds().min().y(), top - 0.5},
          {x + 0.3, bounds().max().y(), top - 0.02}, any(steel_, Label::kCeiling, 1.0));
    }
  }

  // How tall what stands within `radius` of a place may be; endless where nobody flies above.
  double room_above(const Vector2d& place, double radius) const {
    double lowest = std::numeric_limits<double>::infinity();
    const double reach = radius + options_.clear_m;
    for (const Vector3d& flown : options_.flown_W) {
      if ((flown.head<2>() - place).squaredNorm() < reach * reach) lowest = std::min(lowest, flown.z());
    }
    return lowest - options_.clear_m - floor();
  }

  void furnish(const Vector2d& cell) {
    const double radius = random().uniform(0.6, 1.05);
    const double slack = 0.5 * kCell - radius;
    const Vector2d place = cell + Vector2d(random().uniform(-slack, slack), random().uniform(-slack, slack));
    const double most = room_above(place, radius);
    const Isometry3d T_W_F = Eigen::Translation3d(place.x(), place.y(), floor()) *
                             Eigen::AngleAxisd(random().uniform(0.0, std::numbers::pi), Vector3d::UnitZ());
    const int kind = random().below(6);
    if (most < kLowest || kind == 5) return sign_on_floor(T_W_F, radius);
    const double tall = std::min(most, random().uniform(0.8, kTallest));
    if (kind == 4 && most > height()) return pillar(place);
    if (kind == 0 || kind == 4) return machine(T_W_F, radius, tall);
    if (kind == 1) return tank(place, radius, tall);
    if (kind == 2) return rack(T_W_F, radius, tall);
    crates(T_W_F, radius, tall);
  }

  void sign_on_floor(const Isometry3d& T_W_F, double radius) {
    const double half = 0.7 * radius;
    const auto at = [&](double x, double y) { return Vector3d(T_W_F * Vector3d(x, y, 0.01)); };
    picture({at(-half, half), at(-half, -half), at(half, -half), at(half, half)}, Label::kFloor);
  }

  // The whole footprint of each of these stays within the radius.
  void machine(const Isometry3d& T_W_F, double radius, double tall) {
    const double x = 0.8 * radius;
    const double y = 0.6 * radius;
    const double body = 0.65 * tall;
    box(T_W_F, {-x, -y, 0.0}, {x, y, body}, any(machines_, Label::kBox, 2.0));
    box(T_W_F, {-0.5 * x, -0.7 * y, body}, {0.6 * x, 0.5 * y, 0.85 * tall}, any(steel_, Label::kBox, 1.0));
    box(T_W_F, {-0.2 * x, -0.3 * y, 0.85 * tall}, {0.1 * x, 0.1 * y, tall}, any(steel_, Label::kBox, 0.7));
  }

  void tank(const Vector2d& place, double radius, double tall) {
    const Material steel = any(steel_, Label::kBox, 1.3);
    const double wall = 0.8 * tall;
    builder().prism({place.x(), place.y(), floor()}, wall, 0.9 * radius, 0.9 * radius, 12, steel);
    builder().prism({place.x(), place.y(), floor() + wall}, tall - wall, 0.9 * radius, 0.05, 12, steel);
  }

  void rack(const Isometry3d& T_W_F, double radius, double tall) {
    const double x = 0.85 * radius;
    const double y = 0.45 * radius;
    const Material steel = any(steel_, Label::kShelf, 0.6);
    const Material planks = any(planks_, Label::kShelf, 1.2);
    for (const double side : {-x, x - 0.08}) {
      for (const double front : {-y, y - 0.08})
        box(T_W_F, {side, front, 0.0}, {side + 0.08, front + 0.08, tall}, steel);
    }
    for (double z = 0.1; z < tall - 0.15; z += 0.8) {
      box(T_W_F, {-x, -y, z}, {x, y, z + 0.05}, planks);
      const double most = std::min(0.7, tall - z - 0.05);
      for (double left = -x + 0.1; left < x - 0.5;) {
        const double size = random().uniform(0.3, 0.5);
        box(T_W_F, {left, -0.8 * y, z + 0.05},
            {left + size, random().uniform(0.1, 0.8) * y, z + 0.05 + random().uniform(0.5, 0.9) * most},
            any(carton_, Label::kBox, size));
        left += size + random().uniform(0.04, 0.25);
      }
    }
  }

  void crates(const Isometry3d& T_W_F, double radius, double tall) {
    double z = 0.0;
    while (tall - z > 0.2) {
      const double next = std::min(tall - z, random().uniform(0.4, 0.9));
      const double half = radius * random().uniform(0.5, 0.7);
      const Isometry3d T_W_X = T_W_F * Eigen::Translation3d(0.0, 0.0, z) *
                               Eigen::AngleAxisd(random().uniform(-0.3, 0.3), Vector3d::UnitZ());
      box(T_W_X, {-half, -half, 0.0}, {half, half, next}, any(carton_, Label::kBox, 2.0 * half));
      z += next;
    }
  }

  void pillar(const Vector2d& place) {
    const double half = random().uniform(0.2, 0.35);
    box(Isometry3d(Eigen::Translation3d(place.x(), place.y(), floor())), {-half, -half, 0.0},
        {half, half, height() - 0.5}, any(steel_, Label::kPole, 1.5));
  }

  HallOptions options_;
  int paving_;
  int ceiling_;
  std::array<int, 5> walls_ = {};
  std::array<int, 3> steel_ = {};
  std::array<int, 3> machines_ = {};
  std::array<int, 4> carton_ = {};
  std::array<int, 2> planks_ = {};
};

}  // namespace

MeshWorld make_hall(const HallOptions& options) {
  COVEY_CHECK(!options.flown_W.empty());
  return Hall(options).build();
}

}  // namespace covey::sim
