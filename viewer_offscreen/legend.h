// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The list beside a picture that says what its colours mean.

#include <optional>
#include <string>
#include <vector>

#include "viewer_offscreen/scene.h"

namespace covey::viewer {

struct LegendEntry {
  enum class Swatch { kLine, kArea, kStart, kEnd };
  std::string text;
  Rgb colour;
  Swatch swatch = Swatch::kLine;
  double width_px = 3.0;  // of a line
};

struct HeightScale {
  double low_m = 0.0;
  double high_m = 0.0;
};

struct Legend {
  std::vector<LegendEntry> entries;
  std::optional<HeightScale> heights;
};

// unit: the size of everything, 1 for a picture 1200 pixels high.
double legend_width(const Legend& legend, double unit);
// Into a scene for pixel_camera, downwards from its top left corner.
void add_legend(Scene& scene, const Legend& legend, double left, double top, double unit);

// The marks at a trajectory's two ends, in any scene.
void add_start_mark(Scene& scene, const ColouredPoint& point, double unit, int layer = 0);
void add_end_mark(Scene& scene, const ColouredPoint& point, double unit, int layer = 0);

}  // namespace covey::viewer
