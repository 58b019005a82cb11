// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double centre() const { return 0.5 * (low + high); }
  double length() const { return high - low; }
};

// Keeps what is a point or a line from being magnified without end.
constexpr double kSmallestExtent = 0.1;  // metres

// centre_C: the camera's place in axes that are parallel to C and meet in W's origin.
SE3 look(const Eigen::Matrix3d& R_C_W, const Eigen::Vector3d& centre_C) {
  return {SO3::from_matrix(R_C_W), -centre_C};
}

}  // namespace

Eigen::Vector3d Camera::project(const Eigen::Vector3d& p_W) const {
  const Eigen::Vector3d p_C = T_C_W * p_W;
  const double depth = kind == Kind::kPinhole ? p_C.z() : 1.0;
  return {fx * p_C.x() / depth + cx, fy * p_C.y() / depth + cy, p_C.z()};
}

Eigen::Matrix4d Camera::clip_from_world() const {
  // Normalised device x = 2 (u + 1/2) / width - 1, likewise y; z = -1 at near, +1 at far.
  Eigen::Matrix4d clip_from_camera = Eigen::Matrix4d::Zero();
  const double offset_x = (2.0 * cx + 1.0) / width - 1.0;
  const double offset_y = (2.0 * cy + 1.0) / height - 1.0;
  clip_from_camera(0, 0) = 2.0 * fx / width;
  clip_from_camera(1, 1) = 2.0 * fy / height;
  if (kind == Kind::kPinhole) {
    clip_from_camera(0, 2) = offset_x;
    clip_from_camera(1, 2) = offset_y;
    clip_from_camera(2, 2) = (far + near) / (far - near);
    clip_from_camera(2, 3) = -2.0 * far * near / (far - near);
    clip_from_camera(3, 2) = 1.0;
  } else {
    clip_from_camera(0, 3) = offset_x;
    clip_from_camera(1, 3) = offset_y;
    clip_from_camera(2, 2) = 2.0 / (far - near);
    clip_from_camera(2, 3) = -(far + near) / (far - near);
    clip_from_camera(3, 3) = 1.0;
  }
  return clip_from_camera * T_C_W.matrix();
}

Camera top_camera(std::span<const Eigen::Vector3d> points_W, const Frame& frame, PictureSize size) {
  COVEY_CHECK(!points_W.empty());
  Range x;
  Range y;
  Range z;
  for (const Eigen::Vector3d& p : points_W) {
    x.add(p.x());
    y.add(p.y());
    z.add(p.z());
  }
  Camera camera;
  camera.kind = Camera::Kind::kOrthographic;
  camera.width = size.width;
  camera.height = size.height;
  camera.cx = 0.5 * (frame.left + frame.right);
  camera.cy = 0.5 * (frame.top + frame.bottom);
  camera.fx = std::min((frame.right - frame.left) / std::max(x.length(), kSmallestExtent),
                       (frame.bottom - frame.top) / std::max(y.length(), kSmallestExtent));
  camera.fy = camera.fx;
  const Eigen::Matrix3d R_C_W = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  const double reach = 0.05 * std::max({x.length(), y.length(), z.length(), kSmallestExtent});
  camera.near = reach;
  camera.far = 3.0 * reach + z.length();
  camera.T_C_W = look(R_C_W, R_C_W * Eigen::Vector3d(x.centre(), y.centre(), z.high + 2.0 * reach));
  return camera;
}

Camera oblique_camera(std::span<const Eigen::Vector3d> points_W, const Frame& frame, PictureSize size,
                      const ObliqueOptions& options) {
  COVEY_CHECK(!points_W.empty());
  constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  const double azimuth = options.azimuth_deg * kRadPerDeg;
  const double elevation = options.elevation_deg * kRadPerDeg;
  const Eigen::Vector3d forward = -Eigen::Vector3d(
      std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const Eigen::Vector3d right = Eigen::Vector3d(-std::sin(azimuth), std::cos(azimuth), 0.0);
  Eigen::Matrix3d R_C_W;
  R_C_W << right.transpose(), forward.cross(right).transpose(), forward.transpose();

  Camera camera;
  camera.width = size.width;
  camera.height = size.height;
  camera.fx = camera.fy = options.focal * size.height;
  camera.cx = 0.5 * (size.width - 1);
  camera.cy = 0.5 * (size.height - 1);

  // A camera at (X, Y, -d) in these axes sees (x, y, z) at slope (x - X) / (z + d), which must lie in [low,
  // high]:
  //   X + high d >= x - high z  and  X + low d <= x - low z  for all points,
  // so d >= (max(x - high z) - min(x - low z)) / (high - low); the same for y. The larger d of the two holds
  // for both.
  struct Side {
    double low;
    double high;
    Range upper;  // of x - high z
    Range lower;  // of x - low z
    double distance() const { return (upper.high - lower.low) / (high - low); }
    // Half way between the two bounds.
    double place(double d) const { return 0.5 * (upper.high - high * d + lower.low - low * d); }
  };
  Side x{(frame.left - camera.cx) / camera.fx, (frame.right - camera.cx) / camera.fx, {}, {}};
  Side y{(frame.top - camera.cy) / camera.fy, (frame.bottom - camera.cy) / camera.fy, {}, {}};
  Range z;
  for (const Eigen::Vector3d& p_W : points_W) {
    const Eigen::Vector3d p = R_C_W * p_W;
    x.upper.add(p.x() - x.high * p.z());
    x.lower.add(p.x() - x.low * p.z());
    y.upper.add(p.y() - y.high * p.z());
    y.lower.add(p.y() - y.low * p.z());
    z.add(p.z());
  }
  const double nearest = kSmallestExtent * options.focal - z.low;
  const double d = std::max({x.distance(), y.distance(), nearest});
  camera.T_C_W = look(R_C_W, {x.place(d), y.place(d), -d});
  camera.near = 0.5 * (d + z.low);
  camera.far = 1.1 * (d + z.high);
  return camera;
}

Camera pixel_camera(PictureSize size) {
  Camera camera;
  camera.kind = Camera::Kind::kOrthographic;
  camera.width = size.width;
  camera.height = size.height;
  camera.near = 0.0;
  camera.far = 2.0;
  return camera;
}

}  // namespace covey::viewer
