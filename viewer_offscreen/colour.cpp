// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/colour.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

constexpr std::array<Rgb, kPaletteSize> kPalette = {{
    {0, 114, 178},    // blue
    {213, 94, 0},     // vermilion
    {0, 158, 115},    // bluish green
    {204, 121, 167},  // reddish purple
    {230, 159, 0},    // orange
    {86, 180, 233},   // sky blue
    {136, 34, 85},    // wine
    {140, 140, 35},   // olive
    {51, 34, 136},    // indigo
    {60, 60, 60},     // near black
}};

constexpr std::array<Rgb, 6> kHeights = {{
    {52, 28, 98},
    {50, 84, 140},
    {33, 132, 141},
    {61, 178, 112},
    {155, 214, 60},
    {246, 228, 78},
}};

}  // namespace

Rgb palette_colour(int index) { return kPalette[static_cast<std::size_t>(index % kPaletteSize)]; }

Rgb label_colour(int label) {
  constexpr std::array<double, 4> kTints = {0.0, 0.5, 0.25, 0.7};
  const double tint = kTints[static_cast<std::size_t>(label / kPaletteSize % 4)];
  return mix(palette_colour(label), {255, 255, 255}, tint);
}

Rgb height_colour(double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * (kHeights.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kHeights.size() - 2);
  return mix(kHeights[below], kHeights[below + 1], place - static_cast<double>(below));
}

Rgb mix(Rgb a, Rgb b, double fraction) {
  const auto channel = [fraction](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(from + fraction * (to - from)));
  };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

Rgb parse_colour(const std::string& text) {
  unsigned value = 0;
  const char* end = text.data() + text.size();
  const bool shaped = text.size() == 7 && text[0] == '#';
  if (!shaped || std::from_chars(text.data() + 1, end, value, 16).ptr != end) {
    throw_input_error("colour '{}' is not of the form #rrggbb", text);
  }
  return {static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8 & 255),
          static_cast<std::uint8_t>(value & 255)};
}

}  // namespace covey::viewer
