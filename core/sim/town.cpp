// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <vector>

#include "core/sim/mesh_builder.h"
#include "core/sim/mesh_world.h"
#include "core/sim/surfaces.h"

namespace covey::sim {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Distances from a street's centre line, in metres.
constexpr double kClear = 1.7;    // nothing stands nearer
constexpr double kParked = 2.75;  // the middle of a parked car
constexpr double kRoadEdge = 3.0;
constexpr double kFurniture = 3.45;  // poles and street trees
constexpr double kPlot = 4.2;        // where pavement ends and plots begin
constexpr double kOutside = 14.0;    // of the outermost streets: how far the outer plots reach

constexpr int kHouseStyles = 24;
constexpr int kPosterSheets = 8;

struct Palette {
  std::vector<int> asphalt, grass, paving, roofs, leaves, bark, planks, steel, bodywork, posters;
  int tyre = 0;
  int glass = 0;
  std::vector<std::array<int, 2>> houses;  // per style: front with a door, sides
};

Palette paint_palette(MeshBuilder& builder, int side, std::uint64_t seed) {
  std::uint64_t number = 0;
  // Every surface has a seed of its own: to change one leaves the others as they are.
  const auto add = [&](const auto& paint) {
    Random random(mix_seeds(seed, ++number));
    return builder.add_texture(paint(side, random));
  };
  const auto several = [&](std::vector<int>& layers, int count, const auto& paint) {
    for (int i = 0; i < count; ++i) layers.push_back(add(paint));
  };
  Palette palette;
  several(palette.asphalt, 3, paint_asphalt);
  several(palette.grass, 2, paint_grass);
  several(palette.paving, 2, paint_paving);
  several(palette.roofs, 4, paint_roof);
  several(palette.leaves, 3, paint_leaves);
  several(palette.bark, 2, paint_bark);
  several(palette.planks, 3, paint_planks);
  several(palette.steel, 2, paint_steel);
  several(palette.bodywork, 6, paint_bodywork);
  several(palette.posters, kPosterSheets, paint_posters);
  palette.tyre = add(paint_tyre);
  palette.glass = add(paint_glass);
  for (int style = 0; style < kHouseStyles; ++style) {
    const int windows = 2 + style % 3;
    const int front = add([&](int s, Random& random) { return paint_facade(s, random, {2, windows, true}); });
    const int back = add([&](int s, Random& random) { return paint_facade(s, random, {2, windows, false}); });
    palette.houses.push_back({front, back});
  }
  return palette;
}

Isometry3d placed(const Vector2d& place_W, double yaw) {
  return Eigen::Translation3d(place_W.x(), place_W.y(), 0.0) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ());
}

class Town {
 public:
  explicit Town(const TownOptions& options)
      : options_(options),
        random_(mix_seeds(options.seed, 0)),
        builder_("town", options.texture_side),
        palette_(paint_palette(builder_, options.texture_side, options.seed)),
        reach_(options.blocks * options.block_m) {}

  MeshWorld build() {
    lay_roads();
    lay_ground();
    place_blocks();
    place_street_furniture();
    close_streets();
    return std::move(builder_.world());
  }

 private:
  Material material(const std::vector<int>& layers, Label label, double metres) {
    return {layers[static_cast<std::size_t>(random_.below(static_cast<int>(layers.size())))], label, metres,
            tint()};
  }
  viewer::Rgb tint() {
    const auto channel = [&] { return static_cast<std::uint8_t>(random_.uniform(205.0, 255.0)); };
    return {channel(), channel(), channel()};
  }
  // Of one shade each, but of one colour.
  Material surface(const std::vector<int>& layers, Label label, double metres) {
    Material laid = material(layers, label, metres);
    const auto shade = static_cast<std::uint8_t>(random_.uniform(200.0, 255.0));
    laid.tint = {shade, shade, shade};
    return laid;
  }
  Vector2d junction(int i, int j) const { return {i * options_.block_m, j * options_.block_m}; }

  void lay_roads() {
    RoadGraph& roads = builder_.world().roads;
    roads.clear_half_width_m = kClear;
    const int across = options_.blocks + 1;
    for (int j = 0; j < across; ++j) {
      for (int i = 0; i < across; ++i) {
        roads.junctions_W.push_back(junction(i, j));
        if (i + 1 < across) roads.roads.push_back({j * across + i, j * across + i + 1});
        if (j + 1 < across) roads.roads.push_back({j * across + i, (j + 1) * across + i});
      }
    }
  }

  void patch_of_ground(double x0, double y0, double x1, double y1, const Material& material) {
    builder_.ground(AlignedBox2d(Vector2d(x0, y0), Vector2d(x1, y1)), 0.0, material,
                    {random_.uniform(0.0, 1.0), random_.uniform(0.0, 1.0)});
  }

  // The ground is a grid of rectangles between these lines: plots, pavements and roads by turns.
  void lay_ground() {
    std::vector<double> lines = {-kOutside};
    for (int i = 0; i <= options_.blocks; ++i) {
      for (const double side : {-kPlot, -kRoadEdge, kRoadEdge, kPlot})
        lines.push_back(i * options_.block_m + side);
    }
    lines.push_back(reach_ + kOutside);
    const auto kind = [](std::size_t line) { return line % 4; };  // 0 plot, 1 and 3 pavement, 2 road
    for (std::size_t j = 0; j + 1 < lines.size(); ++j) {
      for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
        const bool road = kind(i) == 2 || kind(j) == 2;
        const bool plot = kind(i) == 0 && kind(j) == 0;
        // Paving ends where a road crosses it; along the town's rim it crosses the outer plots.
        const Material laid = road   ? surface(palette_.asphalt, Label::kRoad, 4.0)
                              : plot ? surface(palette_.grass, Label::kGround, 3.0)
                                     : surface(palette_.paving, Label::kPavement, 3.0);
        patch_of_ground(lines[i], lines[j], lines[i + 1], lines[j + 1], laid);
      }
    }
    // Meadows around.
    const double far = 6.0;
    const double low = -kOutside;
    const double high = reach_ + kOutside;
    const Material meadow = {palette_.grass[0], Label::kGround, 5.0, {225, 230, 220}};
    patch_of_ground(low - far, low - far, high + far, low, meadow);
    patch_of_ground(low - far, high, high + far, high + far, meadow);
    patch_of_ground(low - far, low, low, high, meadow);
    patch_of_ground(high, low, high + far, high, meadow);
  }

  // Blocks (-1, -1) to (blocks, blocks): the outer ones close the town in.
  void place_blocks() {
    for (int j = -1; j <= options_.blocks; ++j) {
      for (int i = -1; i <= options_.blocks; ++i) {
        const bool outer = i < 0 || j < 0 || i == options_.blocks || j == options_.blocks;
        const Vector2d centre = junction(i, j) + 0.5 * Vector2d(options_.block_m, options_.block_m);
        // Inside, two of five blocks have no house: squares that one can see across.
        const int turn = (i + 2 * j) % 5;
        if (!outer && turn == 1) {
          garden(centre);
        } else if (!outer && turn == 3) {
          car_park(centre);
        } else {
          plot_with_house(centre);
        }
      }
    }
  }

  void plot_with_house(const Vector2d& centre) {
    // A third of the houses are alike; the others take turns.
    const bool alike = houses_ % 3 == 0;
    const std::size_t style = alike ? 0 : 1 + static_cast<std::size_t>(styled_++ % (kHouseStyles - 1));
    ++houses_;
    const double half = 0.5 * options_.block_m - kPlot - 0.1;
    const Vector2d size = alike
                              ? Vector2d(half, half)
                              : Vector2d(half - random_.uniform(0.0, 0.7), half - random_.uniform(0.0, 0.7));
    const double height = alike ? 5.2 : random_.uniform(4.4, 6.8);
    house(centre, size, height, style, alike ? 0 : random_.below(4), alike);
    if (!alike && random_.chance(0.6)) tree(centre + Vector2d(half - 0.1, -half + 0.1), 0.75);
  }

  void house(const Vector2d& centre, const Vector2d& half, double height, std::size_t style, int turn,
             bool alike) {
    const viewer::Rgb colour = alike ? viewer::Rgb{235, 235, 235} : tint();
    const Isometry3d T_W_H = placed(centre, 0.0);
    const std::array<Vector2d, 4> corners = {
        Vector2d(-half.x(), -half.y()), {half.x(), -half.y()}, half, {-half.x(), half.y()}};
    const auto at = [&](const Vector2d& p, double z) { return Vector3d(T_W_H * Vector3d(p.x(), p.y(), z)); };
    for (int wall = 0; wall < 4; ++wall) {
      const Vector2d& left = corners[static_cast<std::size_t>(wall)];
      const Vector2d& right = corners[static_cast<std::size_t>((wall + 1) % 4)];
      const bool front = (wall + turn) % 2 == 0;
      builder_.quad({at(left, height), at(left, 0.0), at(right, 0.0), at(right, height)}, Patch{},
                    {palette_.houses[style][front ? 0 : 1], Label::kHouse, 1.0, colour});
      if (!alike || wall % 2 == 1) posters(T_W_H, left, right, alike ? 1 : 2);
    }
    // A hipped roof with eaves that stand over.
    const Material tiles = {palette_.roofs[alike ? 0 : static_cast<std::size_t>(random_.below(4))],
                            Label::kHouse, 3.0, colour};
    const double ridge = height + (alike ? 2.0 : random_.uniform(1.4, 2.6));
    for (int wall = 0; wall < 4; ++wall) {
      const Vector2d left = 1.06 * corners[static_cast<std::size_t>(wall)];
      const Vector2d right = 1.06 * corners[static_cast<std::size_t>((wall + 1) % 4)];
      builder_.triangle({at(left, height - 0.15), at(right, height - 0.15), at({0.0, 0.0}, ridge)}, tiles);
    }
    builder_.world().buildings_W.emplace_back(Vector3d(centre.x() - half.x(), centre.y() - half.y(), 0.0),
                                              Vector3d(centre.x() + half.x(), centre.y() + half.y(), height));
  }

  // On a wall, 3 cm proud of it, no two alike.
  void posters(const Isometry3d& T_W_H, const Vector2d& left, const Vector2d& right, int count) {
    const Vector2d along = (right - left).normalized();
    const Vector2d out = 0.03 * Vector2d(along.y(), -along.x());
    const double length = (right - left).norm();
    for (int i = 0; i < count; ++i) {
      const double width = random_.uniform(0.7, 1.3);
      const double height = width * random_.uniform(0.7, 1.3);
      const double x = (i + random_.uniform(0.1, 0.9)) * (length - width) / count;
      const double top = random_.uniform(1.5, 2.7);
      const auto at = [&](double s, double z) {
        const Vector2d p = left + s * along + out;
        return Vector3d(T_W_H * Vector3d(p.x(), p.y(), z));
      };
      const double bottom = top - height;
      picture({at(x, top), at(x, bottom), at(x + width, bottom), at(x + width, top)}, Label::kHouse);
    }
  }

  void picture(const std::array<Vector3d, 4>& corners_W, Label label) {
    const int number = pictures_++ % (kPosterSheets * kPostersOnSheet);
    builder_.quad(corners_W, poster_patch(number / kPosterSheets),
                  {palette_.posters[static_cast<std::size_t>(number % kPosterSheets)], label, 1.0, tint()});
  }

  void garden(const Vector2d& centre) {
    const double half = 0.5 * options_.block_m - kPlot;
    fence_around(centre, half);
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        if (random_.chance(0.85))
          tree(centre + half * Vector2d(x, y) +
                   Vector2d(random_.uniform(-0.7, 0.7), random_.uniform(-0.7, 0.7)),
               1.0);
      }
    }
  }

  void fence_around(const Vector2d& centre, double half) {
    const Material wood = material(palette_.planks, Label::kFence, 1.8);
    const double thickness = 0.04;
    for (int side = 0; side < 4; ++side) {
      const Isometry3d T_W_F = placed(centre, 0.5 * std::numbers::pi * side);
      // An opening in one side, so that it is not a cage.
      const double gate = side == 1 ? 1.2 : 0.0;
      const double height = random_.uniform(0.9, 1.3);
      builder_.box(T_W_F, {-half, -half - thickness, 0.0}, {-gate, -half + thickness, height}, wood, wood);
      builder_.box(T_W_F, {gate, -half - thickness, 0.0}, {half, -half + thickness, height}, wood, wood);
    }
  }

  void car_park(const Vector2d& centre) {
    const double half = 0.5 * options_.block_m - kPlot;
    const Vector2d reach(half, half);
    builder_.ground({centre - reach, centre + reach}, 0.01, surface(palette_.paving, Label::kPavement, 3.0),
                    {random_.uniform(0.0, 1.0), random_.uniform(0.0, 1.0)});
    for (const double y : {-0.5, 0.5}) {
      for (const double x : {-0.6, 0.05, 0.7}) {
        if (random_.chance(0.7))
          car(centre + half * Vector2d(x, y), 0.5 * std::numbers::pi * (random_.chance(0.5) ? 1 : -1));
      }
    }
    pole(centre);
  }

  void tree(const Vector2d& foot, double size) {
    const double trunk = size * random_.uniform(1.5, 2.2);
    const Material bark = material(palette_.bark, Label::kTree, 0.7);
    const Material leaves = material(palette_.leaves, Label::kTree, 1.5);
    const double radius = size * random_.uniform(0.9, 1.35);
    builder_.prism({foot.x(), foot.y(), 0.0}, trunk + 0.5 * radius, 0.17 * size, 0.12 * size, 6, bark);
    builder_.blob(random_, {foot.x(), foot.y(), trunk + 0.85 * radius}, {radius, radius, 1.15 * radius}, 0.16,
                  leaves);
  }

  void pole(const Vector2d& foot) {
    const Material steel = material(palette_.steel, Label::kPole, 1.0);
    const Vector3d base(foot.x(), foot.y(), 0.0);
    const double height = random_.uniform(3.6, 5.0);
    builder_.prism(base, 0.35, 0.14, 0.12, 6, steel);
    builder_.prism(base + Vector3d(0, 0, 0.35), height - 0.35, 0.06, 0.05, 6, steel);
    builder_.box(placed(foot, random_.uniform(0.0, 3.0)), {-0.16, -0.16, height}, {0.16, 0.16, height + 0.4},
                 steel, steel);
    if (random_.chance(0.75)) sign(foot, random_.uniform(1.5, 2.3));
  }

  // A board with a picture on either side, square to one of the streets.
  void sign(const Vector2d& foot, double height) {
    const Isometry3d T_W_S = placed(foot, 0.5 * std::numbers::pi * random_.below(4));
    const double half = random_.uniform(0.22, 0.38);
    for (const double side : {-1.0, 1.0}) {
      const auto at = [&](double x, double z) {
        return Vector3d(T_W_S * Vector3d(side * x, -side * 0.075, height + z));
      };
      picture({at(-half, half), at(-half, -half), at(half, -half), at(half, half)}, Label::kPole);
    }
  }

  void car(const Vector2d& place, double yaw) {
    const Material body = material(palette_.bodywork, Label::kCar, 2.5);
    const Material glass = {palette_.glass, Label::kCar, 1.5, tint()};
    const Isometry3d T_W_V = placed(place, yaw);
    const double length = random_.uniform(1.55, 1.9);  // half
    const double width = random_.uniform(0.72, 0.8);   // half
    const double sill = 0.25;
    const double belt = random_.uniform(0.75, 0.9);
    const double top = belt + random_.uniform(0.5, 0.75);
    builder_.box(T_W_V, {-length, -width, sill}, {length, width, belt}, body, body);
    // The cabin: a frustum of glass under a roof.
    const double back = random_.uniform(-0.95, -0.6) * length;
    const double front = random_.uniform(0.35, 0.55) * length;
    const auto low = [&](bool x, bool y) {
      return Vector3d(T_W_V * Vector3d(x ? front : back, (y ? 1 : -1) * 0.96 * width, belt));
    };
    const auto high = [&](bool x, bool y) {
      return Vector3d(T_W_V * Vector3d(x ? front - 0.45 : back + 0.3, (y ? 1 : -1) * 0.8 * width, top));
    };
    builder_.quad({high(false, false), low(false, false), low(true, false), high(true, false)}, glass);
    builder_.quad({high(true, false), low(true, false), low(true, true), high(true, true)}, glass);
    builder_.quad({high(true, true), low(true, true), low(false, true), high(false, true)}, glass);
    builder_.quad({high(false, true), low(false, true), low(false, false), high(false, false)}, glass);
    builder_.quad({high(false, true), high(false, false), high(true, false), high(true, true)}, body);
    for (const double x : {-0.62, 0.62}) {
      for (const double y : {-1.0, 1.0}) wheel(T_W_V, {x * length, y * width, 0.31}, y);
    }
  }

  // An octagon that stands a little out of the body.
  void wheel(const Isometry3d& T_W_V, const Vector3d& hub, double side) {
    const Material tyre = {palette_.tyre, Label::kCar, 1.0, {255, 255, 255}};
    const auto at = [&](double x, double z) {
      return Vector3d(T_W_V * (hub + Vector3d(side < 0 ? x : -x, side * 0.03, z)));
    };
    const double r = 0.31;
    const double s = 0.41 * r;
    // Three strips of the octagon, each a part of the picture of the wheel.
    builder_.quad({at(-s, r), at(-s, -r), at(s, -r), at(s, r)}, {0.295, 0.0, 0.41, 1.0}, tyre);
    builder_.quad({at(-r, s), at(-r, -s), at(-s, -r), at(-s, r)}, {0.0, 0.0, 0.295, 1.0}, tyre);
    builder_.quad({at(s, r), at(s, -r), at(r, -s), at(r, s)}, {0.705, 0.0, 0.295, 1.0}, tyre);
  }

  // Cars along the kerbs, poles and street trees on the pavements. Nothing near junctions, where one looks around corners.
  void place_street_furniture() {
    for (const auto& [first, second] : builder_.world().roads.roads) {
      const Vector2d from = builder_.world().roads.junctions_W[static_cast<std::size_t>(first)];
      const Vector2d to = builder_.world().roads.junctions_W[static_cast<std::size_t>(second)];
      const Vector2d along = (to - from).normalized();
      const Vector2d left(-along.y(), along.x());
      const double yaw = std::atan2(along.y(), along.x());
      for (const double side : {-1.0, 1.0}) {
        if (random_.chance(0.55)) {
          const double s = random_.uniform(5.6, options_.block_m - 5.6);
          car(from + s * along + side * kParked * left, yaw + (random_.chance(0.5) ? std::numbers::pi : 0.0));
        }
        const double s = random_.uniform(3.8, options_.block_m - 3.8);
        const Vector2d foot = from + s * along + side * (kFurniture + 0.45) * left;
        if (random_.chance(0.55)) {
          pole(foot);
        } else if (random_.chance(0.5)) {
          tree(foot, 0.7);
        }
      }
    }
  }

  // The streets lead out of the town as far as a hoarding with trees behind it: every view ends in something near.
  void close_streets() {
    const Material wood = material(palette_.planks, Label::kFence, 1.8);
    const double height = 2.4;
    for (int street = 0; street <= options_.blocks; ++street) {
      for (int end = 0; end < 4; ++end) {
        // Looking outwards from the town's middle: y ahead.
        const Vector2d middle(0.5 * reach_, 0.5 * reach_);
        const double across = street * options_.block_m - 0.5 * reach_;
        const Isometry3d T_W_E = placed(middle, 0.5 * std::numbers::pi * end) *
                                 Eigen::Translation3d(across, 0.5 * reach_ + kOutside - 4.5, 0.0);
        builder_.box(T_W_E, {-kPlot, 0.0, 0.0}, {kPlot, 0.06, height}, wood, wood);
        for (double x = -kPlot + 0.5; x < kPlot - 1.3; x += random_.uniform(1.5, 2.6)) {
          const double width = random_.uniform(0.8, 1.2);
          const double bottom = random_.uniform(0.4, 1.0);
          const auto at = [&](double right, double up) {
            return Vector3d(T_W_E * Vector3d(x + right, -0.02, bottom + up));
          };
          picture({at(0, width), at(0, 0), at(width, 0), at(width, width)}, Label::kFence);
        }
        for (const double x : {-2.6, 0.3, 2.9}) {
          const Vector3d foot = T_W_E * Vector3d(x + random_.uniform(-0.4, 0.4), 1.8, 0.0);
          tree(foot.head<2>(), random_.uniform(1.1, 1.6));
        }
      }
    }
  }

  TownOptions options_;
  Random random_;
  MeshBuilder builder_;
  Palette palette_;
  double reach_;
  int houses_ = 0;
  int styled_ = 0;
  int pictures_ = 0;
};

}  // namespace

MeshWorld make_town(const TownOptions& options) { return Town(options).build(); }

}  // namespace covey::sim
