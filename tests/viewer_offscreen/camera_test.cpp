// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/camera.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

namespace covey::viewer {
namespace {

constexpr PictureSize kSize = {640, 480};
constexpr Frame kFrame = {50.0, 30.0, 500.0, 420.0};

std::vector<Eigen::Vector3d> random_cloud(unsigned seed, double extent) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-0.5 * extent, 0.5 * extent);
  std::vector<Eigen::Vector3d> points(200);
  for (Eigen::Vector3d& p : points)
    p = {coordinate(random), 0.6 * coordinate(random), 0.2 * coordinate(random)};
  return points;
}

void check_fills_frame(const Camera& camera, const std::vector<Eigen::Vector3d>& points) {
  Eigen::AlignedBox2d seen;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d pixel = camera.project(p);
    seen.extend(Eigen::Vector2d(pixel.head<2>()));
    CHECK(pixel.z() > camera.near);
    CHECK(pixel.z() < camera.far);
  }
  CHECK(seen.min().x() > kFrame.left - 1e-6);
  CHECK(seen.max().x() < kFrame.right + 1e-6);
  CHECK(seen.min().y() > kFrame.top - 1e-6);
  CHECK(seen.max().y() < kFrame.bottom + 1e-6);
  // It touches two opposite sides: no closer camera of this direction sees all points.
  const double slack_x = kFrame.right - kFrame.left - seen.sizes().x();
  const double slack_y = kFrame.bottom - kFrame.top - seen.sizes().y();
  CHECK(std::min(slack_x, slack_y) == Approx(0.0).margin(1e-6));
}

TEST_CASE("a pinhole projects by its intrinsics, and clip coordinates agree with project") {
  Camera camera;
  camera.fx = 300.0;
  camera.fy = 310.0;
  camera.cx = 320.5;
  camera.cy = 200.25;
  camera.width = kSize.width;
  camera.height = kSize.height;
  camera.T_C_W = SE3::exp((Vector6d() << 0.3, -0.2, 0.5, 0.1, 0.2, -0.3).finished());
  const Eigen::Vector3d p_C(0.4, -0.3, 2.0);
  const Eigen::Vector3d p_W = camera.T_C_W.inverse() * p_C;
  const Eigen::Vector3d pixel = camera.project(p_W);
  CHECK(pixel.x() == Approx(300.0 * 0.2 + 320.5));
  CHECK(pixel.y() == Approx(310.0 * -0.15 + 200.25));
  CHECK(pixel.z() == Approx(2.0));
  for (const Camera::Kind kind : {Camera::Kind::kPinhole, Camera::Kind::kOrthographic}) {
    camera.kind = kind;
    const Eigen::Vector4d clip = camera.clip_from_world() * p_W.homogeneous();
    const Eigen::Vector3d expected = camera.project(p_W);
    CHECK((clip.x() / clip.w() + 1.0) * 0.5 * kSize.width - 0.5 == Approx(expected.x()));
    CHECK((clip.y() / clip.w() + 1.0) * 0.5 * kSize.height - 0.5 == Approx(expected.y()));
  }
}

TEST_CASE("near and far are the ends of normalised depth") {
  Camera camera = pixel_camera(kSize);
  for (const Camera::Kind kind : {Camera::Kind::kPinhole, Camera::Kind::kOrthographic}) {
    camera.kind = kind;
    camera.near = 0.5;
    camera.far = 20.0;
    const auto depth = [&](double z) {
      const Eigen::Vector4d clip = camera.clip_from_world() * Eigen::Vector4d(0.0, 0.0, z, 1.0);
      return clip.z() / clip.w();
    };
    CHECK(depth(0.5) == Approx(-1.0));
    CHECK(depth(20.0) == Approx(1.0));
  }
}

TEST_CASE("the top view has x to the right and y up, and fills its frame at every size") {
  for (const double extent : {1.0, 30.0, 10000.0}) {
    const std::vector<Eigen::Vector3d> points = random_cloud(1, extent);
    const Camera camera = top_camera(points, kFrame, kSize);
    check_fills_frame(camera, points);
    const Eigen::Vector3d zero = camera.project(Eigen::Vector3d::Zero());
    CHECK(camera.project(Eigen::Vector3d::UnitX()).x() > zero.x());
    CHECK(camera.project(Eigen::Vector3d::UnitY()).y() < zero.y());
    CHECK(camera.project(Eigen::Vector3d::UnitZ()).z() < zero.z());
  }
}

TEST_CASE("the oblique view has z up and fills its frame from every side") {
  for (const double azimuth_deg : {-160.0, -65.0, 20.0, 110.0}) {
    const std::vector<Eigen::Vector3d> points = random_cloud(2, 30.0);
    const Camera camera = oblique_camera(points, kFrame, kSize, {.azimuth_deg = azimuth_deg});
    check_fills_frame(camera, points);
    CHECK(camera.project(Eigen::Vector3d::UnitZ()).y() < camera.project(Eigen::Vector3d::Zero()).y());
  }
}

TEST_CASE("a single point is framed without magnifying it beyond measure") {
  const std::vector<Eigen::Vector3d> one = {{3.0, -2.0, 1.0}};
  for (const Camera& camera : {top_camera(one, kFrame, kSize), oblique_camera(one, kFrame, kSize)}) {
    const Eigen::Vector3d pixel = camera.project(one[0]);
    CHECK(pixel.x() == Approx(275.0));
    CHECK(pixel.y() == Approx(225.0));
  }
}

}  // namespace
}  // namespace covey::viewer
