// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A world for the front end's tests of which everything is known: one textured wall, the plane z = `distance` of the frame W, looked at by a stereo pair.

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/rig.h"
#include "core/vision/stereo_front_end.h"

namespace covey {

inline Rig test_rig() {
  Rig rig;
  rig.left.camera = {376, 240, 230.0, 229.0, 184.0, 124.0, {-0.28, 0.07, 2e-4, 2e-5}};
  MountedCamera right;
  right.camera = {376, 240, 229.0, 228.0, 190.0, 127.0, {-0.28, 0.07, -1e-4, -3e-5}};
  right.T_B_C.rotation = SO3::exp({0.003, -0.01, 0.012});
  right.T_B_C.translation = {0.11, 0.001, -0.002};
  rig.right = right;
  return rig;
}

class PlaneWorld {
 public:
  explicit PlaneWorld(double distance, std::uint32_t seed = 1) : distance_(distance), seed_(seed) {}

  std::vector<std::uint8_t> render(const MountedCamera& mounted, const SE3& T_W_B) const {
    const PinholeCamera& camera = mounted.camera;
    const SE3 T_W_C = T_W_B * mounted.T_B_C;
    std::vector<std::uint8_t> picture;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const auto m = camera.undistort({x, y});
        const Eigen::Vector3d ray_W = T_W_C.rotation * m.value_or(Eigen::Vector2d::Zero()).homogeneous();
        const double along = (distance_ - T_W_C.translation.z()) / ray_W.z();
        const Eigen::Vector3d p_W = T_W_C.translation + along * ray_W;
        picture.push_back(static_cast<std::uint8_t>(std::lround(brightness(p_W.x(), p_W.y()))));
      }
    }
    return picture;
  }

  // The point of the wall that the left camera sees at m (z = 1).
  Eigen::Vector3d point(const Eigen::Vector2d& m, const SE3& T_W_C) const {
    const Eigen::Vector3d ray_W = T_W_C.rotation * m.homogeneous();
    return T_W_C.translation + (distance_ - T_W_C.translation.z()) / ray_W.z() * ray_W;
  }

 private:
  // Smooth noise in two sizes, in metres on the wall.
  double brightness(double x, double y) const {
    return 40.0 + 120.0 * noise(x / 0.11, y / 0.11) + 60.0 * noise(x / 0.045 + 50.0, y / 0.045);
  }

  // 0 ... 1; random values on a grid, cubic in between.
  double noise(double x, double y) const {
    const double x0 = std::floor(x);
    const double y0 = std::floor(y);
    const auto smooth = [](double s) { return s * s * (3.0 - 2.0 * s); };
    const double sx = smooth(x - x0);
    const double sy = smooth(y - y0);
    const auto at = [&](int dx, int dy) {
      return value(static_cast<int>(x0) + dx, static_cast<int>(y0) + dy);
    };
    return (1 - sy) * ((1 - sx) * at(0, 0) + sx * at(1, 0)) + sy * ((1 - sx) * at(0, 1) + sx * at(1, 1));
  }

  double value(int x, int y) const {
    std::uint32_t h =
        seed_ + static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
    h = (h ^ (h >> 13)) * 1274126177U;
    h = (h ^ (h >> 16)) * 2246822519U;
    return static_cast<double>((h ^ (h >> 13)) & 0xFFFFU) / 65535.0;
  }

  double distance_;
  std::uint32_t seed_;
};

struct PictureSet {
  StereoPictures view(Utime utime) const { return {utime, width, height, left, right}; }
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> left;
  std::vector<std::uint8_t> right;
};

inline PictureSet render_stereo(const PlaneWorld& world, const Rig& rig, const SE3& T_W_B) {
  return {rig.left.camera.width, rig.left.camera.height, world.render(rig.left, T_W_B),
          world.render(*rig.right, T_W_B)};
}

}  // namespace covey
