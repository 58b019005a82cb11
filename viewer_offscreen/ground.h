// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The ground of a figure: a rectangle under what is shown, with lines at round metres of W, from which one
// reads distances and where x and y point.

#include <Eigen/Geometry>
#include <string>

#include "viewer_offscreen/scene.h"

namespace covey::viewer {

struct Ground {
  double x_low = 0.0;
  double x_high = 1.0;
  double y_low = 0.0;
  double y_high = 1.0;
  double z = 0.0;
  double step = 1.0;  // between lines: 1, 2 or 5 times a power of ten
};

// The smallest of 1, 2, 5 times a power of ten that is not below length (> 0).
double round_length(double length);

// "5 m", "20 cm", "2 km".
std::string format_length(double metres);

// "-20", "0.5", "0": beside a line of the ground.
std::string tick_text(double metres);

// Covers the box with a margin; longer in x or y where that brings it to aspect = x / y extent (0: as the box
// has it).
Ground plan_ground(const Eigen::AlignedBox3d& box_W, double aspect);

// Lines and border. The scene is drawn about `origin_W` (its coordinates are W's minus the origin).
void add_ground(Scene& scene, const Ground& ground, const Eigen::Vector3d& origin_W, double width_px);

}  // namespace covey::viewer
