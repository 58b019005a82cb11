// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/text.h"

#include <Eigen/Core>
#include <array>
#include <charconv>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

// A glyph stands on y = 0; capitals reach 14, small letters 10, descenders -4. Strokes:
//   L x y x y ...   straight lines
//   S x y x y ...   an open curve: a quadratic B-spline that starts and ends at the first and last point
//   O x y x y ...   a closed one
struct Glyph {
  char letter;
  double width;
  std::string_view strokes;
};

constexpr double kCapital = 14.0;
constexpr double kGap = 3.2;  // between two glyphs

constexpr std::array kGlyphs = {
    Glyph{' ', 4, ""},
    Glyph{'!', 1, "L 0.5 14 0.5 4.5 L 0.5 0.2 0.5 0"},
    Glyph{'"', 4, "L 0.5 14 0.5 10 L 3.5 14 3.5 10"},
    Glyph{'#', 9, "L 3 14 1.5 0 L 7.5 14 6 0 L 0 9.5 9 9.5 L 0 4.5 9 4.5"},
    Glyph{'$', 9,
          "S 8.5 11 8 13 0.5 13.5 0.5 10 0.5 6.5 8.5 7.5 8.5 3.8 8.5 0.5 1 0.5 0.5 3 L 4.5 15.5 4.5 -1.5"},
    Glyph{'%', 12, "O 0 7.5 0 14 5 14 5 7.5 O 7 0 7 6.5 12 6.5 12 0 L 10.5 14 1.5 0"},
    Glyph{'&', 11, "S 11 0 2 8 2 14 7.5 14 7.5 9 0 7 0 -0.5 7.5 -0.5 10 3 10.5 6"},
    Glyph{'\'', 1, "L 0.5 14 0.5 10"},
    Glyph{'(', 4, "S 4 15.5 0.5 12 0.5 -0.5 4 -4"},
    Glyph{')', 4, "S 0 15.5 3.5 12 3.5 -0.5 0 -4"},
    Glyph{'*', 7, "L 3.5 14 3.5 7 L 0.5 12.2 6.5 8.8 L 0.5 8.8 6.5 12.2"},
    Glyph{'+', 8, "L 4 10 4 2 L 0 6 8 6"},
    Glyph{',', 2, "S 1.2 0.5 1.3 -1.5 0 -3"},
    Glyph{'-', 5, "L 0 5.5 5 5.5"},
    Glyph{'.', 1, "L 0.5 0.2 0.5 0"},
    Glyph{'/', 6, "L 6 15 0 -2"},
    Glyph{'0', 9, "O 0 -0.3 0 14.3 9 14.3 9 -0.3"},
    Glyph{'1', 6, "L 0.5 11 4 14 4 0"},
    Glyph{'2', 9, "S 0.5 10.5 0.5 14 8.5 14.8 8.5 10 8.5 7.5 4 4.5 0 0 L 0 0 9 0"},
    Glyph{'3', 9,
          "S 0.5 11.5 1.2 14.2 8.3 14.8 8.3 10.6 8.3 7.5 5 7.5 3 7.5 S 3 7.5 5.5 7.5 9 7 9 3.8 9 -1 0.8 -0.8 "
          "0 3"},
    Glyph{'4', 9, "L 7 0 7 14 0 4 9.5 4"},
    Glyph{'5', 9, "L 8 14 1.3 14 0.7 7.4 S 0.7 7.4 2 9.2 9 9.8 9 4.5 9 -1 0.8 -0.9 0 2.8"},
    Glyph{'6', 9, "S 7.8 14 2 12 0 8 0 4.5 0 -1.5 9 -1.5 9 4.5 9 10 0.5 10 0.2 4.8"},
    Glyph{'7', 9, "L 0 14 9 14 S 9 14 4.5 8 3.2 4 3 0"},
    Glyph{'8', 9, "O 0.7 7.4 0.7 14.3 8.3 14.3 8.3 7.4 O 0 -0.3 0 7.6 9 7.6 9 -0.3"},
    Glyph{'9', 9, "S 1.2 0 7 2 9 6 9 9.5 9 15.5 0 15.5 0 9.5 0 4 8.5 4 8.8 9.2"},
    Glyph{':', 1, "L 0.5 9 0.5 8.8 L 0.5 0.2 0.5 0"},
    Glyph{';', 2, "L 1.2 9 1.2 8.8 S 1.2 0.5 1.3 -1.5 0 -3"},
    Glyph{'<', 7, "L 7 10.5 0 6 7 1.5"},
    Glyph{'=', 8, "L 0 8 8 8 L 0 4 8 4"},
    Glyph{'>', 7, "L 0 10.5 7 6 0 1.5"},
    Glyph{'?', 7, "S 0 11 0 14.3 7 14.8 7 10.5 7 8 3.5 7.5 3.5 4.5 L 3.5 0.2 3.5 0"},
    Glyph{'@', 14,
          "S 10 4 9 2 4 2 4 6 4 10.5 10 10.5 10 7 S 10 9.5 9.5 2.5 14 2 14 7 14 16 0 16 0 6 0 -4 8 -4 12 -2"},
    Glyph{'A', 11, "L 0 0 5.5 14 11 0 L 1.9 4.8 9.1 4.8"},
    Glyph{'B', 9,
          "L 0 0 0 14 4.5 14 S 4.5 14 8.5 14 8.5 7.4 4.5 7.4 L 4.5 7.4 0 7.4 L 4.5 7.4 5 7.4 S 5 7.4 9.3 7.4 "
          "9.3 0 5 0 L 5 0 0 0"},
    Glyph{'C', 10, "S 10 11 8.5 14.2 0 15.2 0 7 0 -1.2 8.5 -0.2 10 3"},
    Glyph{'D', 10, "L 0 0 0 14 4 14 S 4 14 10 14 10 7 10 0 4 0 L 4 0 0 0"},
    Glyph{'E', 8, "L 8 14 0 14 0 0 8 0 L 0 7.4 7 7.4"},
    Glyph{'F', 8, "L 8 14 0 14 0 0 L 0 7.2 7 7.2"},
    Glyph{'G', 11, "S 10.2 11.3 8.5 14.4 0 15.2 0 7 0 -1.4 9.5 -0.4 10.5 2.5 L 10.5 2.5 10.5 6.5 6 6.5"},
    Glyph{'H', 10, "L 0 0 0 14 L 10 0 10 14 L 0 7.3 10 7.3"},
    Glyph{'I', 1, "L 0.5 0 0.5 14"},
    Glyph{'J', 7, "S 6.5 14 6.5 4 6.5 -1.3 0.6 -1.3 0 3.2"},
    Glyph{'K', 9, "L 0 0 0 14 L 8.5 14 0 5.5 L 3 8.4 9 0"},
    Glyph{'L', 8, "L 0 14 0 0 7.5 0"},
    Glyph{'M', 12, "L 0 0 0 14 6 4 12 14 12 0"},
    Glyph{'N', 10, "L 0 0 0 14 10 0 10 14"},
    Glyph{'O', 12, "O 0 -0.4 0 14.4 12 14.4 12 -0.4"},
    Glyph{'P', 9, "L 0 0 0 14 4.8 14 S 4.8 14 9 14 9 6.6 4.8 6.6 L 4.8 6.6 0 6.6"},
    Glyph{'Q', 12, "O 0 -0.4 0 14.4 12 14.4 12 -0.4 L 7 3.5 11.8 -1"},
    Glyph{'R', 9, "L 0 0 0 14 4.8 14 S 4.8 14 8.8 14 8.8 7 4.8 7 L 4.8 7 0 7 L 4.8 7 9 0"},
    Glyph{'S', 9, "S 8.4 11.2 7.8 14.2 0.5 14.8 0.5 10.4 0.5 6.6 8.9 7.8 8.9 3.8 8.9 -0.9 0.7 -0.7 0 3"},
    Glyph{'T', 10, "L 0 14 10 14 L 5 14 5 0"},
    Glyph{'U', 10, "S 0 14 0 4.5 0 -1.5 10 -1.5 10 4.5 10 14"},
    Glyph{'V', 11, "L 0 14 5.5 0 11 14"},
    Glyph{'W', 15, "L 0 14 4 0 7.5 14 11 0 15 14"},
    Glyph{'X', 10, "L 0 14 10 0 L 10 14 0 0"},
    Glyph{'Y', 10, "L 0 14 5 6.5 10 14 L 5 6.5 5 0"},
    Glyph{'Z', 9, "L 0 14 9 14 0 0 9 0"},
    Glyph{'[', 3, "L 3 15.5 0 15.5 0 -3.5 3 -3.5"},
    Glyph{'\\', 6, "L 0 15 6 -2"},
    Glyph{']', 3, "L 0 15.5 3 15.5 3 -3.5 0 -3.5"},
    Glyph{'^', 7, "L 0 9 3.5 14 7 9"},
    Glyph{'_', 8, "L 0 -2.5 8 -2.5"},
    Glyph{'`', 3, "L 0 14.5 3 11.5"},
    Glyph{
        'a', 8,
        "S 0.5 8 1.2 10.3 7.7 11.2 7.7 6.5 L 7.7 6.5 7.7 0 S 7.7 6 -0.2 6.5 -0.2 2.7 -0.2 -1 6.5 -0.8 7.7 3"},
    Glyph{'b', 8, "L 0 14.5 0 0 S 0 6 1 10.2 8.3 11.3 8.3 5 8.3 -1.3 1 -0.2 0 4"},
    Glyph{'c', 7, "S 7.2 7.6 6.5 10.1 0 11 0 5 0 -1 6.5 -0.1 7.2 2.4"},
    Glyph{'d', 8, "L 8 14.5 8 0 S 8 6 7 10.2 -0.3 11.3 -0.3 5 -0.3 -1.3 7 -0.2 8 4"},
    Glyph{'e', 8, "L 0.2 5.3 8 5.3 S 8 5.3 8 10.5 0 11.3 0 5 0 -1.2 7 -0.5 7.8 2.3"},
    Glyph{'f', 5, "S 5.2 14.3 1.8 15 1.8 10.5 1.8 8 L 1.8 9 1.8 0 L 0 9.5 4.8 9.5"},
    Glyph{'g', 8,
          "L 8 10 8 0 S 8 1 8 -5 1.5 -4.8 0.6 -2.4 S 8 6 7 10.2 -0.3 11.3 -0.3 5 -0.3 -1.3 7 -0.2 8 4"},
    Glyph{'h', 8, "L 0 14.5 0 0 S 0 5.5 0.8 10 7.6 12 7.6 5.5 L 7.6 5.8 7.6 0"},
    Glyph{'i', 1, "L 0.5 10 0.5 0 L 0.5 13.6 0.5 13.4"},
    Glyph{'j', 3, "S 2 10 2 0 2 -3.6 1.3 -4.2 -0.5 -4 L 2 13.6 2 13.4"},
    Glyph{'k', 7, "L 0 14.5 0 0 L 6.8 10 0 4 L 2.6 6.3 7.2 0"},
    Glyph{'l', 1, "L 0.5 14.5 0.5 0"},
    Glyph{'m', 13,
          "L 0 10 0 0 S 0 5.5 0.7 10 6.5 12 6.5 5.5 L 6.5 5.8 6.5 0 S 6.5 5.5 7.2 10 13 12 13 5.5 L 13 5.8 "
          "13 0"},
    Glyph{'n', 8, "L 0 10 0 0 S 0 5.5 0.8 10 7.6 12 7.6 5.5 L 7.6 5.8 7.6 0"},
    Glyph{'o', 9, "O 0 -0.3 0 10.3 8.8 10.3 8.8 -0.3"},
    Glyph{'p', 8, "L 0 10 0 -4.2 S 0 6 1 10.2 8.3 11.3 8.3 5 8.3 -1.3 1 -0.2 0 4"},
    Glyph{'q', 8, "L 8 10 8 -4.2 S 8 6 7 10.2 -0.3 11.3 -0.3 5 -0.3 -1.3 7 -0.2 8 4"},
    Glyph{'r', 5, "L 0 10 0 0 S 0 5.5 0.6 9.6 3 10.4 5 9.8"},
    Glyph{'s', 7, "S 6.6 8 6 10.2 0.4 10.6 0.4 7.4 0.4 4.6 7 5.6 7 2.6 7 -0.7 0.6 -0.4 0 2.1"},
    Glyph{'t', 5, "S 1.8 13.2 1.8 5 1.8 -0.4 3.4 -0.3 5 0 L 0 9.7 4.7 9.7"},
    Glyph{'u', 8, "L 7.6 10 7.6 0 S 7.6 4.5 6.8 0 0 -2 0 4.5 L 0 4.2 0 10"},
    Glyph{'v', 8, "L 0 10 4 0 8 10"},
    Glyph{'w', 12, "L 0 10 3.2 0 6 10 8.8 0 12 10"},
    Glyph{'x', 8, "L 0 10 7.6 0 L 7.6 10 0 0"},
    Glyph{'y', 8, "L 0 10 4 0.3 L 8 10 4 0.3 S 4 0.3 2.8 -3.6 1.6 -4.4 -0.2 -4"},
    Glyph{'z', 7, "L 0.2 10 7 10 0 0 7.2 0"},
    Glyph{'{', 4, "S 4 15.5 2 15.5 2 13 2 6.5 0 6 S 0 6 2 5.5 2 -1 2 -3.5 4 -3.5"},
    Glyph{'|', 1, "L 0.5 15.5 0.5 -3.5"},
    Glyph{'}', 4, "S 0 15.5 2 15.5 2 13 2 6.5 4 6 S 4 6 2 5.5 2 -1 2 -3.5 0 -3.5"},
    Glyph{'~', 9, "S 0 5 1 8 4 7 5 5 8 4 9 7"},
};

constexpr Glyph kUnknown = {'\0', 8, "L 0 0 0 14 8 14 8 0 0 0"};

using Stroke = std::vector<Eigen::Vector2d>;

const Glyph& glyph_of(char letter) {
  const int place = letter - ' ';
  return place >= 0 && place < static_cast<int>(kGlyphs.size()) ? kGlyphs[static_cast<std::size_t>(place)]
                                                                : kUnknown;
}

// Corner cutting (G. Chaikin, 1974), which tends to the quadratic B-spline of the polygon.
Stroke cut_corners(const Stroke& polygon, bool closed) {
  Stroke cut;
  const std::size_t edges = closed ? polygon.size() : polygon.size() - 1;
  if (!closed) cut.push_back(polygon.front());
  for (std::size_t i = 0; i < edges; ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    cut.push_back(0.75 * a + 0.25 * b);
    cut.push_back(0.25 * a + 0.75 * b);
  }
  if (!closed) cut.push_back(polygon.back());
  return cut;
}

Stroke finish(char kind, Stroke stroke) {
  const bool closed = kind == 'O';
  for (int round = 0; kind != 'L' && round < 3; ++round) stroke = cut_corners(stroke, closed);
  if (closed) stroke.push_back(stroke.front());
  return stroke;
}

std::vector<Stroke> strokes_of(const Glyph& glyph) {
  std::vector<Stroke> strokes;
  Stroke stroke;
  char kind = 'L';
  const auto end_stroke = [&] {
    if (!stroke.empty()) strokes.push_back(finish(kind, std::move(stroke)));
    stroke.clear();
  };
  const char* at = glyph.strokes.data();
  const char* const end = at + glyph.strokes.size();
  while (at < end) {
    if (*at == ' ') {
      ++at;
    } else if (*at == 'L' || *at == 'S' || *at == 'O') {
      end_stroke();
      kind = *at++;
    } else {
      Eigen::Vector2d p;
      const auto x = std::from_chars(at, end, p.x());
      COVEY_CHECK(x.ec == std::errc() && x.ptr < end);
      const auto y = std::from_chars(x.ptr + 1, end, p.y());
      COVEY_CHECK(y.ec == std::errc());
      stroke.push_back(p);
      at = y.ptr;
    }
  }
  end_stroke();
  return strokes;
}

}  // namespace

double text_width(std::string_view text, double height_px) {
  double units = 0.0;
  for (const char letter : text) units += glyph_of(letter).width + kGap;
  return text.empty() ? 0.0 : (units - kGap) * height_px / kCapital;
}

void add_text(Scene& scene, std::string_view text, double x, double y, const TextStyle& style) {
  const double scale = style.height_px / kCapital;
  const double width = text_width(text, style.height_px);
  if (style.align == Align::kCentre) x -= 0.5 * width;
  if (style.align == Align::kRight) x -= width;
  std::vector<ColouredPoint> segments;
  const auto add = [&](const Eigen::Vector2d& p) {
    segments.push_back(
        {Eigen::Vector3d(x + scale * p.x(), y - scale * p.y(), 1.0).cast<float>(), style.colour});
  };
  for (const char letter : text) {
    const Glyph& glyph = glyph_of(letter);
    for (const Stroke& stroke : strokes_of(glyph)) {
      for (std::size_t i = 1; i < stroke.size(); ++i) {
        add(stroke[i - 1]);
        add(stroke[i]);
      }
    }
    x += scale * (glyph.width + kGap);
  }
  scene.add_lines(segments, {.width_px = 0.5 + 0.085 * style.height_px, .form = LineForm::kSegments});
}

}  // namespace covey::viewer
