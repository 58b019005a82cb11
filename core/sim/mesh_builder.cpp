// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/base/error.h"

namespace covey::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Two axes of a face's plane: along level ground, and downwards or, on level faces, away from y.
std::pair<Vector3d, Vector3d> face_axes(const Vector3d& normal_W) {
  const bool level = std::abs(normal_W.z()) > 0.9;
  const Vector3d along = level ? Vector3d::UnitX() : Vector3d::UnitZ().cross(normal_W).normalized();
  return {along, level ? Vector3d(-Vector3d::UnitY()) : Vector3d(along.cross(normal_W).normalized())};
}

std::uint8_t times(std::uint8_t a, double factor) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(a * factor, 0.0, 255.0)));
}

struct Ball {
  std::vector<Vector3d> directions;
  std::vector<std::array<int, 3>> faces;
};

Ball icosahedron() {
  const double t = std::numbers::phi;
  Ball ball;
  for (const auto& [x, y, z] : std::initializer_list<std::array<double, 3>>{{-1, t, 0},
                                                                            {1, t, 0},
                                                                            {-1, -t, 0},
                                                                            {1, -t, 0},
                                                                            {0, -1, t},
                                                                            {0, 1, t},
                                                                            {0, -1, -t},
                                                                            {0, 1, -t},
                                                                            {t, 0, -1},
                                                                            {t, 0, 1},
                                                                            {-t, 0, -1},
                                                                            {-t, 0, 1}}) {
    ball.directions.push_back(Vector3d(x, y, z).normalized());
  }
  ball.faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return ball;
}

Ball cut_in_four(const Ball& coarse) {
  Ball fine;
  fine.directions = coarse.directions;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [found, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<int>(fine.directions.size()));
    if (is_new) {
      const Vector3d sum =
          fine.directions[static_cast<std::size_t>(a)] + fine.directions[static_cast<std::size_t>(b)];
      fine.directions.push_back(sum.normalized());
    }
    return found->second;
  };
  for (const auto& [a, b, c] : coarse.faces) {
    const int ab = middle(a, b);
    const int bc = middle(b, c);
    const int ca = middle(c, a);
    fine.faces.insert(fine.faces.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

}  // namespace

MeshBuilder::MeshBuilder(std::string name, int texture_side) {
  world_.name = std::move(name);
  world_.textures.side = texture_side;
}

int MeshBuilder::add_texture(const Canvas& canvas) {
  COVEY_CHECK(canvas.side() == world_.textures.side);
  const std::vector<std::uint8_t> rgb = canvas.rgb();
  world_.textures.rgb.insert(world_.textures.rgb.end(), rgb.begin(), rgb.end());
  std::array<double, 3> sums = {};
  for (std::size_t i = 0; i < rgb.size(); ++i) sums[i % 3] += rgb[i];
  const double count = static_cast<double>(rgb.size()) / 3.0;
  means_.push_back({static_cast<float>(sums[0] / count), static_cast<float>(sums[1] / count),
                    static_cast<float>(sums[2] / count)});
  return world_.textures.layers() - 1;
}

viewer::Rgb MeshBuilder::lit(const viewer::Rgb& tint, const Vector3d& normal_W) const {
  // An overcast sky with its brighter half in the south-west.
  const double light = 0.78 + 0.22 * normal_W.dot(Vector3d(-0.45, -0.6, 0.66));
  return {times(tint.r, light), times(tint.g, light), times(tint.b, light)};
}

std::uint32_t MeshBuilder::vertex(const Vector3d& p_W, const Vector2d& uv, const Material& material,
                                  const viewer::Rgb& tint) {
  viewer::Mesh& mesh = world_.mesh;
  mesh.vertices.push_back(p_W.cast<float>());
  const Paint& mean = means_[static_cast<std::size_t>(material.layer)];
  mesh.colours.push_back(
      {times(tint.r, mean.r / 255.0), times(tint.g, mean.g / 255.0), times(tint.b, mean.b / 255.0)});
  mesh.labels.push_back(static_cast<std::uint16_t>(material.label));
  mesh.texture.push_back({static_cast<float>(uv.x()), static_cast<float>(uv.y()),
                          static_cast<std::uint16_t>(material.layer), tint});
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void MeshBuilder::quad(const std::array<Vector3d, 4>& corners_W, const Patch& patch,
                       const Material& material) {
  const Vector3d normal = (corners_W[2] - corners_W[0]).cross(corners_W[3] - corners_W[1]).normalized();
  const viewer::Rgb tint = lit(material.tint, normal);
  const std::uint32_t a = vertex(corners_W[0], {patch.u, patch.v}, material, tint);
  const std::uint32_t b = vertex(corners_W[1], {patch.u, patch.v + patch.height}, material, tint);
  const std::uint32_t c =
      vertex(corners_W[2], {patch.u + patch.width, patch.v + patch.height}, material, tint);
  const std::uint32_t d = vertex(corners_W[3], {patch.u + patch.width, patch.v}, material, tint);
  world_.mesh.faces.push_back({a, b, c});
  world_.mesh.faces.push_back({a, c, d});
}

void MeshBuilder::quad(const std::array<Vector3d, 4>& corners_W, const Material& material) {
  quad(corners_W,
       {0.0, 0.0, (corners_W[3] - corners_W[0]).norm() / material.metres,
        (corners_W[1] - corners_W[0]).norm() / material.metres},
       material);
}

void MeshBuilder::triangle(const std::array<Vector3d, 3>& corners_W, const Material& material) {
  const Vector3d normal = (corners_W[1] - corners_W[0]).cross(corners_W[2] - corners_W[0]).normalized();
  const viewer::Rgb tint = lit(material.tint, normal);
  const auto [along, down] = face_axes(normal);
  std::array<std::uint32_t, 3> face = {};
  for (std::size_t i = 0; i < 3; ++i) {
    face[i] =
        vertex(corners_W[i], Vector2d(along.dot(corners_W[i]), down.dot(corners_W[i])) / material.metres,
               material, tint);
  }
  world_.mesh.faces.push_back(face);
}

void MeshBuilder::ground(const Eigen::AlignedBox2d& box_W, double z, const Material& material,
                         const Vector2d& shift) {
  const Vector2d& low = box_W.min();
  const Vector2d& high = box_W.max();
  const Vector2d size = (high - low) / material.metres;
  quad({Vector3d(low.x(), high.y(), z),
        {low.x(), low.y(), z},
        {high.x(), low.y(), z},
        {high.x(), high.y(), z}},
       {low.x() / material.metres + shift.x(), -high.y() / material.metres + shift.y(), size.x(), size.y()},
       material);
}

void MeshBuilder::box(const Eigen::Isometry3d& T_W_X, const Vector3d& low, const Vector3d& high,
                      const Material& side, const Material& top) {
  const auto corner = [&](bool x, bool y, bool z) {
    return T_W_X * Vector3d(x ? high.x() : low.x(), y ? high.y() : low.y(), z ? high.z() : low.z());
  };
  quad({corner(false, false, true), corner(false, false, false), corner(true, false, false),
        corner(true, false, true)},
       side);
  quad({corner(true, true, true), corner(true, true, false), corner(false, true, false),
        corner(false, true, true)},
       side);
  quad({corner(true, false, true), corner(true, false, false), corner(true, true, false),
        corner(true, true, true)},
       side);
  quad({corner(false, true, true), corner(false, true, false), corner(false, false, false),
        corner(false, false, true)},
       side);
  quad({corner(false, true, true), corner(false, false, true), corner(true, false, true),
        corner(true, true, true)},
       top);
  if (corner(false, false, false).z() > 1e-3) {
    quad({corner(false, false, false), corner(false, true, false), corner(true, true, false),
          corner(true, false, false)},
         top);
  }
}

void MeshBuilder::prism(const Vector3d& foot_W, double height, double radius_low, double radius_high,
                        int sides, const Material& material) {
  const auto corner = [&](int side, bool high) {
    const double angle = 2.0 * std::numbers::pi * side / sides;
    const double radius = high ? radius_high : radius_low;
    return Vector3d(foot_W +
                    Vector3d(radius * std::cos(angle), radius * std::sin(angle), high ? height : 0.0));
  };
  const double around = 2.0 * std::numbers::pi * radius_low / material.metres / sides;
  for (int side = 0; side < sides; ++side) {
    quad({corner(side, true), corner(side, false), corner(side + 1, false), corner(side + 1, true)},
         {side * around, 0.0, around, height / material.metres}, material);
  }
}

void MeshBuilder::blob(Random& random, const Vector3d& centre_W, const Vector3d& radii, double lumps,
                       const Material& material) {
  const Ball ball = cut_in_four(icosahedron());
  std::vector<Vector3d> points_W;
  for (const Vector3d& direction : ball.directions) {
    points_W.emplace_back(centre_W +
                          random.uniform(1.0 - lumps, 1.0 + lumps) * direction.cwiseProduct(radii));
  }
  for (const auto& [a, b, c] : ball.faces) {
    triangle({points_W[static_cast<std::size_t>(a)], points_W[static_cast<std::size_t>(b)],
              points_W[static_cast<std::size_t>(c)]},
             material);
  }
}

}  // namespace covey::sim
