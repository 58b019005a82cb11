// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A small font of pen strokes, drawn for Covey: printable ASCII as lines that the renderer draws like any other, sharp
// at every size. Pictures with text need no font file.

#include <Eigen/Core>
#include <string_view>
#include <vector>

#include "viewer_offscreen/scene.h"

namespace covey::viewer {

// Width in pixels of a line of text whose capitals are height_px high.
double text_width(std::string_view text, double height_px);

enum class Align { kLeft, kCentre, kRight };

struct TextStyle {
  double height_px = 14.0;  // of a capital letter
  Rgb colour = {40, 40, 40};
  Align align = Align::kLeft;
};

// The text's strokes as segments (LineForm::kSegments) in pixels, y down, z = 1, for pixel_camera. The baseline starts
// (or is centred, or ends) at (x, y). A byte outside printable ASCII is drawn as a box.
std::vector<ColouredPoint> text_segments(std::string_view text, double x, double y, const TextStyle& style);

// The pen's width that suits a height.
double pen_width(double height_px);

}  // namespace covey::viewer
