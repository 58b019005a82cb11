// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/mesh_world.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "core/sim/cameras.h"
#include "core/sim/labels.h"
#include "tests/core/sim/scenes.h"

namespace covey::sim {
namespace {

using Eigen::AlignedBox3d;
using Eigen::Vector3d;

constexpr int kSmall = 64;  // texels; where nobody looks at the surfaces

AlignedBox3d box_of(const viewer::Mesh& mesh, const std::array<std::uint32_t, 3>& face) {
  AlignedBox3d box;
  for (const std::uint32_t corner : face) box.extend(mesh.vertices[corner].cast<double>());
  return box;
}

bool same(const MeshWorld& a, const MeshWorld& b) {
  return a.mesh.vertices == b.mesh.vertices && a.mesh.labels == b.mesh.labels &&
         a.mesh.faces == b.mesh.faces && a.textures.rgb == b.textures.rgb;
}

void check_consistent(const MeshWorld& world) {
  const viewer::Mesh& mesh = world.mesh;
  REQUIRE(mesh.colours.size() == mesh.vertices.size());
  REQUIRE(mesh.labels.size() == mesh.vertices.size());
  REQUIRE(mesh.texture.size() == mesh.vertices.size());
  int wrong = 0;
  for (const auto& face : mesh.faces) {
    for (const std::uint32_t corner : face) {
      const bool right =
          corner < mesh.vertices.size() && mesh.texture[corner].layer < world.textures.layers() &&
          mesh.texture[corner].layer == mesh.texture[face[0]].layer &&
          mesh.labels[corner] == mesh.labels[face[0]] && mesh.labels[corner] < kLabelClasses.size();
      wrong += !right;
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("a town follows from its seed, and has every class of a town") {
  const MeshWorld town = make_town({.seed = 4, .texture_side = kSmall});
  check_consistent(town);
  CHECK(same(town, make_town({.seed = 4, .texture_side = kSmall})));
  CHECK_FALSE(same(town, make_town({.seed = 5, .texture_side = kSmall})));
  const std::set<std::uint16_t> classes(town.mesh.labels.begin(), town.mesh.labels.end());
  for (const Label label : {Label::kGround, Label::kRoad, Label::kPavement, Label::kHouse, Label::kTree,
                            Label::kCar, Label::kPole, Label::kFence}) {
    CHECK(classes.count(static_cast<std::uint16_t>(label)) == 1);
  }
}

// Nothing of a world from 1 cm to `tallest` above where one drives.
int in_the_way(const MeshWorld& world, double tallest) {
  std::vector<AlignedBox3d> free;
  for (const auto& [first, second] : world.roads.roads) {
    AlignedBox3d box;
    for (const int junction : {first, second}) {
      const Eigen::Vector2d& p = world.roads.junctions_W[static_cast<std::size_t>(junction)];
      const double half = world.roads.clear_half_width_m;
      box.extend(Vector3d(p.x() - half, p.y() - half, 0.01));
      box.extend(Vector3d(p.x() + half, p.y() + half, tallest));
    }
    free.push_back(box);
  }
  int count = 0;
  for (const auto& face : world.mesh.faces) {
    const AlignedBox3d box = box_of(world.mesh, face);
    for (const AlignedBox3d& road : free) count += box.intersects(road);
  }
  return count;
}

TEST_CASE("nothing stands on a town's streets, for any seed") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const MeshWorld town = make_town({.seed = seed, .texture_side = 1});
    REQUIRE(town.roads.junctions_W.size() == 25);
    REQUIRE(town.roads.roads.size() == 40);
    CHECK(in_the_way(town, 9.0) == 0);
  }
}

TEST_CASE("rooms follow from their seed, and nothing stands where one drives through them") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const MeshWorld rooms = make_rooms({.seed = seed, .texture_side = 1});
    check_consistent(rooms);
    CHECK(same(rooms, make_rooms({.seed = seed, .texture_side = 1})));
    CHECK_FALSE(same(rooms, make_rooms({.seed = seed + 1, .texture_side = 1})));
    CHECK(in_the_way(rooms, 2.0) == 0);
  }
}

// Names of what stands in a room, with its size and where its middle is across the floor, to 30 cm: a hand's breadth is allowed.
int shelves_in_place(const MeshWorld& world, const AlikeRooms& alike) {
  const auto shelves = [&](const Eigen::Isometry3d& T_W_R) {
    std::vector<AlignedBox3d> boxes;
    for (std::size_t k = 0; k < world.mesh.faces.size(); ++k) {
      const auto& face = world.mesh.faces[k];
      if (world.mesh.labels[face[0]] != static_cast<std::uint16_t>(Label::kShelf)) continue;
      AlignedBox3d box;
      for (const std::uint32_t corner : face)
        box.extend(T_W_R.inverse() * world.mesh.vertices[corner].cast<double>());
      if (rooms_inside().contains(box)) boxes.push_back(box);
    }
    return boxes;
  };
  const auto a = shelves(alike.T_W_A);
  const auto b = shelves(alike.T_W_B);
  if (a.size() != b.size()) return 0;
  int count = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    count += (a[k].sizes() - b[k].sizes()).norm() < 1e-4 && (a[k].center() - b[k].center()).norm() < 0.25;
  return count == static_cast<int>(a.size()) ? count : 0;
}

TEST_CASE("rooms that are alike have the same furniture in the same places, nearly") {
  const MeshWorld rooms = make_rooms({.seed = 1, .texture_side = 1});
  REQUIRE(alike_rooms().size() == 4);
  for (const AlikeRooms& alike : alike_rooms()) {
    CHECK(shelves_in_place(rooms, alike) > 10);
    CHECK((alike.T_W_A.translation() - alike.T_W_B.translation()).norm() > 6.0);
  }
}

TEST_CASE("a third of a town's houses are of one type, and every house stops sight") {
  const MeshWorld town = make_town({.seed = 2, .texture_side = kSmall});
  REQUIRE(town.buildings_W.size() >= 25);
  // A wall's texture tells the type; all walls of a house stand in its box.
  std::map<std::set<int>, int> types;
  for (const AlignedBox3d& building : town.buildings_W) {
    std::set<int> layers;
    for (const auto& face : town.mesh.faces) {
      const AlignedBox3d box = box_of(town.mesh, face);
      const bool wall = box.sizes().z() == Approx(building.sizes().z()) &&
                        (box.center() - building.center()).norm() < 6.0 &&
                        building.squaredExteriorDistance(box.center()) < 1e-6;
      if (wall && town.mesh.labels[face[0]] == static_cast<std::uint16_t>(Label::kHouse))
        layers.insert(town.mesh.texture[face[0]].layer);
    }
    REQUIRE(layers.size() == 2);  // front and sides
    ++types[layers];
  }
  int most = 0;
  for (const auto& [layers, count] : types) most = std::max(most, count);
  CHECK(most == static_cast<int>(town.buildings_W.size() + 2) / 3);
  CHECK(types.size() >= 18);
}

TEST_CASE("a room follows from its seed, and nothing is in the way of who flies in it") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const MeshWorld room = make_room({.seed = seed, .texture_side = 1});
    check_consistent(room);
    CHECK(same(room, make_room({.seed = seed, .texture_side = 1})));
    AlignedBox3d flown = room_flight_volume();
    flown.min().array() -= 0.5;
    flown.max().array() += 0.5;
    for (const auto& face : room.mesh.faces) REQUIRE_FALSE(box_of(room.mesh, face).intersects(flown));
  }
}

// From a place to the nearest of some points of a face.
double distance(const viewer::Mesh& mesh, const std::array<std::uint32_t, 3>& face, const Vector3d& place) {
  constexpr int kSteps = 12;
  const auto corner = [&](std::size_t k) { return Vector3d(mesh.vertices[face[k]].cast<double>()); };
  double nearest = 1e9;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      const double a = static_cast<double>(i) / kSteps;
      const double b = static_cast<double>(j) / kSteps;
      const Vector3d p = a * corner(0) + b * corner(1) + (1.0 - a - b) * corner(2);
      nearest = std::min(nearest, (p - place).norm());
    }
  }
  return nearest;
}

// Two storeys of a figure of eight, and a dive between them.
std::vector<Vector3d> flight() {
  std::vector<Vector3d> places;
  for (double t = 0.0; t < 12.6; t += 0.01)
    places.emplace_back(6.0 * std::sin(t), 4.0 * std::sin(2.0 * t), 1.5 + 1.3 * std::sin(0.5 * t));
  return places;
}

TEST_CASE("a hall follows from its seed and its flights, and nothing is in their way") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const HallOptions options{.seed = seed, .texture_side = 1, .flown_W = flight()};
    const MeshWorld hall = make_hall(options);
    check_consistent(hall);
    CHECK(same(hall, make_hall(options)));
    CHECK(hall.mesh.faces.size() > 500);
    double nearest = 1e9;
    for (const auto& face : hall.mesh.faces) {
      const AlignedBox3d box = box_of(hall.mesh, face);
      for (std::size_t k = 0; k < options.flown_W.size(); k += 5) {
        if (box.exteriorDistance(options.flown_W[k]) > nearest) continue;
        nearest = std::min(nearest, distance(hall.mesh, face, options.flown_W[k]));
      }
    }
    CAPTURE(seed);
    CHECK(nearest >= 0.49);  // the floor; what stands on it keeps clear_m
  }
}

// Places of a picture, 16 pixels apart, with a corner in the sense of Shi and Tomasi (CVPR 1994): the smaller eigenvalue of the mean
// gradient tensor over 5 x 5 pixels stands out of what noise makes of a plain surface.
int corners(const stereo_t& stereo) {
  constexpr int kCell = 16;
  constexpr double kLeast = 40.0;  // grey levels^2 per pixel^2
  std::set<int> cells;
  const auto grey = [&](int u, int v) {
    return static_cast<double>(stereo.left[static_cast<std::size_t>(v * stereo.width + u)]);
  };
  for (int v = 4; v < stereo.height - 4; v += 2) {
    for (int u = 4; u < stereo.width - 4; u += 2) {
      double xx = 0.0;
      double xy = 0.0;
      double yy = 0.0;
      for (int j = v - 2; j <= v + 2; ++j) {
        for (int i = u - 2; i <= u + 2; ++i) {
          const double gx = 0.5 * (grey(i + 1, j) - grey(i - 1, j));
          const double gy = 0.5 * (grey(i, j + 1) - grey(i, j - 1));
          xx += gx * gx;
          xy += gx * gy;
          yy += gy * gy;
        }
      }
      const double smaller = 0.5 * (xx + yy - std::sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy)) / 25.0;
      if (smaller > kLeast) cells.insert((v / kCell) * 100 + u / kCell);
    }
  }
  return static_cast<int>(cells.size());
}

// One camera, that looks along x of the body from so far above it, with z upwards.
Rig forward_camera(double above) {
  Eigen::Matrix3d R_B_C;
  R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Rig rig = lens_rig();
  rig.left.T_B_C = {SO3::from_matrix(R_B_C), {0, 0, above}};
  rig.right.reset();
  return rig;
}

TEST_CASE("every view along a town's streets has 150 corners in places of their own") {
  const MeshWorld town = make_town();
  SensorCameras cameras(town, forward_camera(0.5));
  int views = 0;
  int fewest = 10'000;
  for (const auto& [first, second] : town.roads.roads) {
    if (++views % 3 != 0) continue;
    const Eigen::Vector2d from = town.roads.junctions_W[static_cast<std::size_t>(first)];
    const Eigen::Vector2d to = town.roads.junctions_W[static_cast<std::size_t>(second)];
    const Eigen::Vector2d middle = 0.3 * from + 0.7 * to;
    const double yaw = std::atan2(to.y() - from.y(), to.x() - from.x()) + (views % 2 == 0 ? 0.0 : 0.7);
    const int found =
        corners(cameras.stereo({SO3::exp(Vector3d(0, 0, yaw)), {middle.x(), middle.y(), 0.0}}, views));
    fewest = std::min(fewest, found);
  }
  CAPTURE(fewest);
  CHECK(fewest >= 150);
  // The measure is worth something: an empty picture has none.
  stereo_t plain = cameras.stereo({SO3::exp(Vector3d(0, -1.5, 0)), {0, 0, 20.0}}, 1);
  CHECK(corners(plain) == 0);
}

TEST_CASE("every view from a flight through a hall has 100 corners in places of their own") {
  const std::vector<Vector3d> places = flight();
  const MeshWorld hall = make_hall({.flown_W = places});
  SensorCameras cameras(hall, forward_camera(0.0));
  int fewest = 10'000;
  for (std::size_t k = 0; k < places.size(); k += 60) {
    const SE3 T_W_B{SO3::exp(Vector3d(0, 0, 0.05 * static_cast<double>(k))), places[k]};
    fewest = std::min(fewest, corners(cameras.stereo(T_W_B, static_cast<Utime>(k + 1))));
  }
  CAPTURE(fewest);
  CHECK(fewest >= 100);
}

}  // namespace
}  // namespace covey::sim
