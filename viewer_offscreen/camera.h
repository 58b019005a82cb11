// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A camera maps a point to a pixel and a depth. Camera frame C: x right, y down, z forward (the optical
// axis). Pixels: (0, 0) is the centre of the top left pixel, so a picture of width w spans u in [-0.5, w -
// 0.5].
//   pinhole       u = fx x / z + cx,  v = fy y / z + cy
//   orthographic  u = s x + cx,       v = s y + cy          s in pixels per metre
// depth is z_C in metres for both. The frame of the drawn geometry is called W.

#include <Eigen/Core>
#include <span>

#include "core/geometry/se3.h"

namespace covey::viewer {

struct Camera {
  enum class Kind { kPinhole, kOrthographic };
  Kind kind = Kind::kPinhole;
  SE3 T_C_W;
  double fx = 1.0;  // pixels, or pixels per metre
  double fy = 1.0;
  double cx = 0.0;
  double cy = 0.0;
  double near = 0.05;  // metres along z; what lies outside [near, far] is not drawn
  double far = 100.0;
  int width = 0;
  int height = 0;

  // (u, v, depth); z > 0 is needed for a pinhole.
  Eigen::Vector3d project(const Eigen::Vector3d& p_W) const;
  // OpenGL's clip coordinates of a point in W, with clip y growing downwards: the first row of the
  // framebuffer is then the picture's top row, and no picture has to be turned over.
  Eigen::Matrix4d clip_from_world() const;
};

// The part of a picture that the content shall fill, in pixels.
struct Frame {
  double left = 0.0;
  double top = 0.0;
  double right = 0.0;
  double bottom = 0.0;
};

struct PictureSize {
  int width = 0;
  int height = 0;
};

// Looks down: x_W to the right, y_W up, all points inside the frame and centred in it.
Camera top_camera(std::span<const Eigen::Vector3d> points_W, const Frame& frame, PictureSize size);

struct ObliqueOptions {
  double azimuth_deg = -65.0;   // where the camera stands, from x_W towards y_W
  double elevation_deg = 38.0;  // above the ground
  double focal = 1.6;           // focal length in picture heights: a portrait lens bends less
};

// Perspective from a distance at which all points lie just inside the frame.
Camera oblique_camera(std::span<const Eigen::Vector3d> points_W, const Frame& frame, PictureSize size,
                      const ObliqueOptions& options = {});

// For legends and text: one unit of x and y is one pixel, y down; z is 1.
Camera pixel_camera(PictureSize size);

}  // namespace covey::viewer
