// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/camera.h"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

namespace covey {
namespace {

PinholeCamera euroc() {
  return {
      752, 480, 458.654, 457.296, 367.215, 248.375, {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}};
}

// The lens of TUM's visual-inertial dataset (Schubert et al., IROS 2018), cam0 at 512 x 512.
PinholeCamera fisheye() {
  return {512,
          512,
          190.978,
          190.973,
          254.932,
          256.897,
          {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673},
          LensModel::kEquidistant};
}

TEST_CASE("Undistorting a pixel and distorting it again gives the pixel, over the whole picture") {
  for (const PinholeCamera& camera : {euroc(), fisheye()}) {
    int seen = 0;
    int asked = 0;
    for (double u = 0.0; u < camera.width; u += 37.0) {
      for (double v = 0.0; v < camera.height; v += 31.0) {
        ++asked;
        const auto m = camera.undistort({u, v});
        if (!m) continue;
        ++seen;
        CHECK((camera.distort(*m) - Eigen::Vector2d(u, v)).norm() < 1e-6);
        const auto pixel = camera.project(2.5 * m->homogeneous());
        REQUIRE(pixel);
        CHECK((*pixel - Eigen::Vector2d(u, v)).norm() < 1e-6);
      }
    }
    CHECK(seen >= (camera.lens == LensModel::kEquidistant ? 0.8 * asked : asked));
  }
}

TEST_CASE("A fisheye lens shows angles, and nothing beyond its widest") {
  PinholeCamera camera = fisheye();
  camera.distortion = {};
  const auto pixel = camera.project({std::tan(0.5), 0.0, 1.0});
  REQUIRE(pixel);
  CHECK(pixel->x() == Approx(camera.cx + camera.fx * 0.5));
  CHECK(camera.undistort({camera.cx + camera.fx * 1.3, camera.cy}));
  CHECK_FALSE(camera.undistort({camera.cx + camera.fx * 1.45, camera.cy}));
  const auto middle = camera.undistort({camera.cx, camera.cy});
  REQUIRE(middle);
  CHECK(middle->norm() == 0.0);
}

TEST_CASE("The distortion's Jacobian is its numeric one") {
  for (const PinholeCamera& camera : {euroc(), fisheye()}) {
    for (const Eigen::Vector2d& m :
         {Eigen::Vector2d(0.4, -0.3), Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(-0.7, 0.1)}) {
      Eigen::Matrix2d J;
      camera.distort(m, &J);
      constexpr double kStep = 1e-6;
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector2d d = kStep * Eigen::Vector2d::Unit(i);
        const Eigen::Vector2d numeric = (camera.distort(m + d) - camera.distort(m - d)) / (2.0 * kStep);
        CHECK((J.col(i) - numeric).norm() < 1e-5);
      }
    }
  }
}

TEST_CASE("Without distortion projection is the pinhole's, and needs a point in front") {
  PinholeCamera camera = euroc();
  camera.distortion = {};
  const auto pixel = camera.project({0.2, -0.1, 2.0});
  REQUIRE(pixel);
  CHECK(pixel->x() == Approx(458.654 * 0.1 + 367.215));
  CHECK(pixel->y() == Approx(457.296 * -0.05 + 248.375));
  CHECK_FALSE(camera.project({0.0, 0.0, -1.0}));
  CHECK(camera.contains({-0.4, 0.0}));
  CHECK_FALSE(camera.contains({751.6, 0.0}));
}

TEST_CASE("A pixel that no point can have is told") {
  PinholeCamera camera = euroc();
  camera.distortion = {-0.5, 0.0, 0.0, 0.0};  // |m| (1 - |m|^2 / 2) never exceeds 0.544
  CHECK(camera.undistort({camera.cx + 0.5 * camera.fx, camera.cy}));
  CHECK_FALSE(camera.undistort({camera.cx + 0.6 * camera.fx, camera.cy}));
  CHECK_FALSE(camera.undistort({-3000.0, 248.0}));
}

}  // namespace
}  // namespace covey
