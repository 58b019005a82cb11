// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A small font of pen strokes, drawn for Covey: printable ASCII as lines that the renderer draws like any
// other, sharp at every size. Pictures with text need no font file.

#include <string_view>

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

// Draws one line of text into a scene for pixel_camera. The baseline starts (or is centred, or ends) at (x,
// y) in pixels, y down. A byte outside printable ASCII is drawn as a box.
void add_text(Scene& scene, std::string_view text, double x, double y, const TextStyle& style = {});

}  // namespace covey::viewer
