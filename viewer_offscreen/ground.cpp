// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace covey::viewer {

double round_length(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= length * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

std::string tick_text(double metres) { return fmt::format("{:g}", metres + 0.0); }  // -0.0 + 0.0 is 0.0

std::string format_length(double metres) {
  if (metres >= 1000.0) return fmt::format("{:g} km", metres / 1000.0);
  if (metres >= 1.0) return fmt::format("{:g} m", metres);
  if (metres >= 0.01) return fmt::format("{:g} cm", metres * 100.0);
  return fmt::format("{:g} mm", metres * 1000.0);
}

Ground plan_ground(const Eigen::AlignedBox3d& box_W, double aspect) {
  const Eigen::Vector3d centre = box_W.center();
  const Eigen::Vector3d sizes = box_W.sizes();
  constexpr double kMargin = 1.1;
  constexpr double kSlimmest = 0.35;  // of the longer side: a straight drive still gets a strip of ground
  const double longer = std::max({sizes.x(), sizes.y(), 0.3 * sizes.z(), 0.1});
  double x_size = kMargin * std::max(sizes.x(), kSlimmest * longer);
  double y_size = kMargin * std::max(sizes.y(), kSlimmest * longer);
  if (aspect > 0.0) {
    x_size = std::max(x_size, aspect * y_size);
    y_size = std::max(y_size, x_size / aspect);
  }
  Ground ground;
  ground.x_low = centre.x() - 0.5 * x_size;
  ground.x_high = centre.x() + 0.5 * x_size;
  ground.y_low = centre.y() - 0.5 * y_size;
  ground.y_high = centre.y() + 0.5 * y_size;
  ground.z = box_W.min().z();
  ground.step = round_length(std::max(x_size, y_size) / 11.0);
  return ground;
}

void add_ground(Scene& scene, const Ground& ground, const Eigen::Vector3d& origin_W, double width_px) {
  constexpr Rgb kLine = {226, 229, 233};
  constexpr Rgb kBorder = {176, 182, 190};
  std::vector<ColouredPoint> lines;
  std::vector<ColouredPoint> border;
  const auto add = [&](std::vector<ColouredPoint>& to, Rgb colour, double x0, double y0, double x1,
                       double y1) {
    to.push_back({(Eigen::Vector3d(x0, y0, ground.z) - origin_W).cast<float>(), colour});
    to.push_back({(Eigen::Vector3d(x1, y1, ground.z) - origin_W).cast<float>(), colour});
  };
  // Counted in whole steps, so that no line is lost to rounding far from the origin.
  for (double i = std::ceil(ground.x_low / ground.step); i * ground.step < ground.x_high; ++i) {
    add(lines, kLine, i * ground.step, ground.y_low, i * ground.step, ground.y_high);
  }
  for (double i = std::ceil(ground.y_low / ground.step); i * ground.step < ground.y_high; ++i) {
    add(lines, kLine, ground.x_low, i * ground.step, ground.x_high, i * ground.step);
  }
  add(border, kBorder, ground.x_low, ground.y_low, ground.x_high, ground.y_low);
  add(border, kBorder, ground.x_high, ground.y_low, ground.x_high, ground.y_high);
  add(border, kBorder, ground.x_high, ground.y_high, ground.x_low, ground.y_high);
  add(border, kBorder, ground.x_low, ground.y_high, ground.x_low, ground.y_low);
  scene.add_lines(lines, {.width_px = width_px, .layer = -2, .form = LineForm::kSegments});
  scene.add_lines(border, {.width_px = 1.3 * width_px, .layer = -1, .form = LineForm::kSegments});
}

}  // namespace covey::viewer
