// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Colours that a colour-blind colleague can tell apart, and that stay apart on a projector.
// Robots and labels: the eight of Okabe and Ito ("Color Universal Design", 2008) without their yellow, which
// is lost on white paper, and with four darker ones between them. Heights: blue over green to yellow, even in
// lightness, so that higher is lighter in a grey print too.

#include <cstdint>
#include <string>

namespace covey::viewer {

struct Rgb {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  bool operator==(const Rgb&) const = default;
};

constexpr int kPaletteSize = 10;

// Index 0 to 9 is distinct; from 10 on they repeat.
Rgb palette_colour(int index);

// A label's colour: the palette, then shades of it, so that the first 40 labels differ.
Rgb label_colour(int label);

// fraction in [0, 1] (outside it is clamped), low to high.
Rgb height_colour(double fraction);

// fraction 0 gives a, 1 gives b.
Rgb mix(Rgb a, Rgb b, double fraction);

// "#rrggbb"; InputError otherwise.
Rgb parse_colour(const std::string& text);

}  // namespace covey::viewer
