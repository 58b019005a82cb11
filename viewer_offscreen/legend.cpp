// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "viewer_offscreen/text.h"

namespace covey::viewer {
namespace {

constexpr double kText = 13.0;
constexpr double kSwatch = 34.0;
constexpr double kGap = 13.0;
constexpr double kRow = 31.0;
constexpr double kScaleHeight = 220.0;
constexpr Rgb kPaper = {255, 255, 255};

ColouredPoint at(double x, double y, Rgb colour) {
  return {Eigen::Vector3d(x, y, 1.0).cast<float>(), colour};
}

std::string high_text(const HeightScale& scale) { return fmt::format("{:.3g} m", scale.high_m); }
std::string low_text(const HeightScale& scale) { return fmt::format("{:.3g} m", scale.low_m); }

void add_swatch(Scene& scene, const LegendEntry& entry, double left, double y, double unit) {
  const double right = left + kSwatch * unit;
  const double middle = 0.5 * (left + right);
  switch (entry.swatch) {
    case LegendEntry::Swatch::kLine: {
      const std::array line = {at(left, y, entry.colour), at(right, y, entry.colour)};
      scene.add_lines(line, {.width_px = entry.width_px});
      break;
    }
    case LegendEntry::Swatch::kArea: {
      const std::array point = {at(middle, y, entry.colour)};
      scene.add_points(point, {.size_px = 18.0 * unit, .shape = PointShape::kSquare});
      break;
    }
    case LegendEntry::Swatch::kStart:
      add_start_mark(scene, at(middle, y, entry.colour), unit);
      break;
    case LegendEntry::Swatch::kEnd:
      add_end_mark(scene, at(middle, y, entry.colour), unit);
      break;
  }
}

void add_height_scale(Scene& scene, const HeightScale& scale, double left, double top, double unit) {
  Mesh bar;
  constexpr int kSteps = 50;
  for (int i = 0; i <= kSteps; ++i) {
    const double fraction = static_cast<double>(i) / kSteps;
    const double y = top + (1.0 - fraction) * kScaleHeight * unit;
    for (const double x : {left, left + 18.0 * unit}) {
      const ColouredPoint corner = at(x, y, height_colour(fraction));
      bar.vertices.push_back(corner.p_W);
      bar.colours.push_back(corner.colour);
    }
    const auto first = static_cast<std::uint32_t>(2 * i);
    if (i == kSteps) break;
    bar.faces.push_back({first, first + 1, first + 2});
    bar.faces.push_back({first + 2, first + 1, first + 3});
  }
  scene.add(bar);
  const TextStyle style = {.height_px = kText * unit};
  const double text_left = left + 30.0 * unit;
  add_text(scene, high_text(scale), text_left, top + kText * unit, style);
  add_text(scene, low_text(scale), text_left, top + kScaleHeight * unit, style);
  add_text(scene, "height", text_left, top + 0.5 * (kScaleHeight + kText) * unit, style);
}

}  // namespace

double legend_width(const Legend& legend, double unit) {
  double widest = 0.0;
  for (const LegendEntry& entry : legend.entries) widest = std::max(widest, text_width(entry.text, kText));
  if (legend.heights) {
    for (const std::string& text : {high_text(*legend.heights), low_text(*legend.heights)}) {
      widest = std::max(widest, text_width(text, kText));
    }
  }
  return widest > 0.0 ? unit * (kSwatch + kGap + widest) : 0.0;
}

void add_legend(Scene& scene, const Legend& legend, double left, double top, double unit) {
  double y = top;
  for (const LegendEntry& entry : legend.entries) {
    const double middle = y + 0.5 * kText * unit;
    add_swatch(scene, entry, left, middle, unit);
    add_text(scene, entry.text, left + (kSwatch + kGap) * unit, y + kText * unit,
             {.height_px = kText * unit});
    y += kRow * unit;
  }
  if (legend.heights) add_height_scale(scene, *legend.heights, left, y + kGap * unit, unit);
}

void add_start_mark(Scene& scene, const ColouredPoint& point, double unit, int layer) {
  const ColouredPoint hole = {point.p_W, kPaper};
  scene.add_points(std::span(&point, 1), {.size_px = 16.0 * unit, .layer = layer});
  scene.add_points(std::span(&hole, 1), {.size_px = 8.5 * unit, .layer = layer + 1});
}

void add_end_mark(Scene& scene, const ColouredPoint& point, double unit, int layer) {
  const ColouredPoint rim = {point.p_W, kPaper};
  scene.add_points(std::span(&rim, 1),
                   {.size_px = 17.0 * unit, .layer = layer, .shape = PointShape::kSquare});
  scene.add_points(std::span(&point, 1),
                   {.size_px = 13.0 * unit, .layer = layer + 1, .shape = PointShape::kSquare});
}

}  // namespace covey::viewer
