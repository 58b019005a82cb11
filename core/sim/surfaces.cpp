// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/surfaces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace covey::sim {
namespace {

// A broken line that wanders, as cracks and scratches do.
void crack(Canvas& canvas, Random& random, double length, double width, const Paint& paint) {
  double x = random.uniform(0.0, 1.0);
  double y = random.uniform(0.0, 1.0);
  double heading = random.uniform(0.0, 2.0 * std::numbers::pi);
  for (double gone = 0.0; gone < length; gone += 0.02) {
    heading += random.uniform(-0.6, 0.6);
    const double next_x = x + 0.02 * std::cos(heading);
    const double next_y = y + 0.02 * std::sin(heading);
    canvas.stroke(x, y, next_x, next_y, width, paint);
    x = next_x;
    y = next_y;
  }
}

// Upright and level bars in the cells of a line: looks like writing and has its corners.
void lettering(Canvas& canvas, Random& random, double x, double y, double height, int letters,
               const Paint& paint) {
  const double pitch = 0.75 * height;
  const double pen = std::max(0.16 * height, 1.2 / canvas.side());
  for (int i = 0; i < letters; ++i) {
    const double left = x + i * pitch;
    const double width = 0.55 * height;
    if (random.chance(0.12)) continue;  // a gap between words
    if (random.chance(0.7)) canvas.rectangle(left, y, pen, height, paint);
    if (random.chance(0.5)) canvas.rectangle(left + width - pen, y, pen, height, paint);
    for (const double level : {0.0, 0.42, 0.84}) {
      if (random.chance(0.5)) canvas.rectangle(left, y + level * height, width, pen, paint);
    }
    if (random.chance(0.3)) canvas.stroke(left, y, left + width, y + height, pen, paint);
  }
}

Paint contrasting(Random& random, const Paint& paint) {
  const double brightness = (paint.r + paint.g + paint.b) / 3.0;
  return brightness > 120.0 ? random_paint(random, 10.0, 60.0) : random_paint(random, 190.0, 250.0);
}

void window(Canvas& canvas, Random& random, double x, double y, double width, double height,
            const Paint& frame, int style) {
  const double bar = 0.012;
  if (style % 3 == 1) {  // shutters beside it
    const Paint shutter = random_paint(random, 40.0, 180.0);
    for (const double left : {x - 0.4 * width, x + width}) {
      canvas.rectangle(left, y, 0.4 * width, height, shutter);
      for (double slat = y + 0.01; slat < y + height - 0.008; slat += 0.018) {
        canvas.rectangle(left + 0.05 * width, slat, 0.3 * width, 0.007, scaled(shutter, 0.6));
      }
    }
  }
  canvas.rectangle(x - bar, y - bar, width + 2 * bar, height + 2 * bar, frame);
  const Paint glass = scaled({50, 60, 75}, random.uniform(0.4, 1.5));
  canvas.rectangle(x, y, width, height, glass);
  // Sky in the panes, a curtain, a plant on the sill: no two windows are the same.
  canvas.rectangle(x, y, width, height * random.uniform(0.1, 0.5), scaled(glass, random.uniform(1.3, 2.2)));
  const Paint curtain = random_paint(random, 90.0, 240.0);
  if (random.chance(0.7)) canvas.rectangle(x, y, width * random.uniform(0.1, 0.4), height, curtain);
  if (random.chance(0.7)) {
    const double share = random.uniform(0.1, 0.4);
    canvas.rectangle(x + width * (1.0 - share), y, width * share, height,
                     scaled(curtain, random.uniform(0.7, 1.1)));
  }
  if (random.chance(0.5)) {
    canvas.disc(x + width * random.uniform(0.3, 0.7), y + 0.8 * height, 0.15 * height,
                {60, static_cast<float>(random.uniform(60, 150)), 50});
  }
  if (random.chance(0.25))
    lettering(canvas, random, x + 0.1 * width, y + 0.4 * height, 0.2 * height, 4, curtain);
  if (style % 2 == 0) canvas.rectangle(x + 0.5 * width - 0.5 * bar, y, bar, height, frame);
  canvas.rectangle(x, y + (style % 4 < 2 ? 0.33 : 0.5) * height, width, bar, frame);
  canvas.rectangle(x - 0.03, y + height + bar, width + 0.06, 0.016, scaled(frame, 0.8));  // sill
}

void door(Canvas& canvas, Random& random, double x, double top, double width, const Paint& frame) {
  const Paint leaf = random_paint(random, 40.0, 150.0);
  canvas.rectangle(x - 0.02, top - 0.02, width + 0.04, 1.02 - top, frame);
  canvas.rectangle(x, top, width, 1.0 - top, leaf);
  for (const double level : {0.08, 0.38, 0.68}) {
    for (const double side : {0.12, 0.56}) {
      canvas.rectangle(x + side * width, top + level * (1.0 - top), 0.32 * width, 0.24 * (1.0 - top),
                       scaled(leaf, random.uniform(0.5, 1.8)));
    }
  }
  canvas.disc(x + 0.9 * width, top + 0.55 * (1.0 - top), 0.007, {230, 210, 120});
  canvas.rectangle(x + width + 0.03, top + 0.1, 0.035, 0.03, {240, 240, 235});
  lettering(canvas, random, x + width + 0.034, top + 0.106, 0.016, 2, {20, 20, 60});
}

void poster(Canvas& canvas, Random& random, double x, double y, double size) {
  const Paint paper = random_paint(random, 60.0, 250.0);
  canvas.rectangle(x, y, size, size, paper);
  // Everything stays inside: the neighbours are other pictures.
  const auto place = [&](double extent) { return random.uniform(0.0, size - extent); };
  const int shapes = 5 + random.below(8);
  for (int i = 0; i < shapes; ++i) {
    const Paint ink = random_paint(random, 0.0, 255.0);
    const double width = size * random.uniform(0.06, 0.5);
    const double height = size * random.uniform(0.06, 0.5);
    const int kind = random.below(4);
    if (kind == 0) {
      canvas.rectangle(x + place(width), y + place(height), width, height, ink);
    } else if (kind == 1) {
      const double radius = 0.5 * std::min(width, height);
      canvas.disc(x + radius + place(2 * radius), y + radius + place(2 * radius), radius, ink);
    } else if (kind == 2) {
      const double pen = size * random.uniform(0.02, 0.06);
      canvas.stroke(x + pen + place(2 * pen), y + pen + place(2 * pen), x + pen + place(2 * pen),
                    y + pen + place(2 * pen), pen, ink);
    } else {
      const double cell = size * random.uniform(0.035, 0.07);
      const int across = 3 + random.below(3);
      const double left = x + place(across * cell);
      const double top = y + place(across * cell);
      for (int row = 0; row < across; ++row) {
        for (int column = 0; column < across; ++column) {
          if (random.chance(0.5)) canvas.rectangle(left + column * cell, top + row * cell, cell, cell, ink);
        }
      }
    }
  }
  const int lines = 2 + random.below(3);
  for (int line = 0; line < lines; ++line) {
    const double height = size * random.uniform(0.05, 0.13);
    const int letters = std::min(4 + random.below(8), static_cast<int>(0.9 * size / (0.75 * height)));
    lettering(canvas, random, x + 0.05 * size, y + place(height), height, letters,
              contrasting(random, paper));
  }
  const double rim = 0.025 * size;
  const Paint frame = random_paint(random, 0.0, 255.0);
  canvas.rectangle(x, y, size, rim, frame);
  canvas.rectangle(x, y + size - rim, size, rim, frame);
  canvas.rectangle(x, y, rim, size, frame);
  canvas.rectangle(x + size - rim, y, rim, size, frame);
}

void paint_wall(Canvas& canvas, Random& random) {
  const int kind = random.below(5);
  const double brightness = random.uniform(0.75, 1.15);
  if (kind == 0) {
    canvas.masonry(random, 22, 56, 0.004, scaled({160, 80, 60}, brightness),
                   scaled({205, 195, 185}, brightness), 0.35, true);
  } else if (kind == 1) {
    canvas.masonry(random, 10, 16, 0.006, scaled({175, 165, 145}, brightness), {80, 75, 70}, 0.35, true);
  } else if (kind == 2) {
    canvas.masonry(random, 1, 30, 0.006, scaled(random_paint(random, 110, 210), brightness), {60, 55, 50},
                   0.2, false);
  } else if (kind == 3) {
    canvas.masonry(random, 8, 6, 0.008, scaled(random_paint(random, 130, 220), brightness), {90, 90, 95},
                   0.22, false);
  } else {
    canvas.fill(scaled(random_paint(random, 150, 235), brightness));
    canvas.speckle(random, 300, 0.002, 0.02, 0.8, 1.15);
  }
  canvas.mottle(random, 0.14, 2, 8, 0.85);
}

}  // namespace

Canvas paint_asphalt(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill({125, 125, 128});
  for (int i = 0; i < 9; ++i) {  // mended places
    canvas.rectangle(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0.04, 0.3),
                     random.uniform(0.04, 0.25), scaled({120, 120, 124}, random.uniform(0.55, 1.35)));
  }
  canvas.mottle(random, 0.22, 2, 9, 0.85);
  canvas.speckle(random, 2600, 0.0015, 0.007, 0.35, 2.1);
  canvas.speckle(random, 60, 0.006, 0.025, 0.45, 1.6);
  for (int i = 0; i < 12; ++i) crack(canvas, random, random.uniform(0.2, 0.8), 0.006, {35, 35, 38});
  for (int i = 0; i < 30; ++i) {  // leaves and litter
    canvas.rectangle(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0.006, 0.02),
                     random.uniform(0.006, 0.02), random_paint(random, 20, 250));
  }
  return canvas;
}

Canvas paint_grass(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill({80, 120, 50});
  canvas.mottle(random, 0.35, 2, 6, 0.8);
  for (int i = 0; i < 5000; ++i) {
    const double x = random.uniform(0, 1);
    const double y = random.uniform(0, 1);
    canvas.stroke(x, y, x + random.uniform(-0.015, 0.015), y + random.uniform(-0.02, 0.02), 0.004,
                  scaled({90, 135, 55}, random.uniform(0.35, 1.6)));
  }
  canvas.speckle(random, 120, 0.004, 0.012, 1.6, 2.4);
  canvas.speckle(random, 60, 0.008, 0.03, 0.4, 0.7);
  return canvas;
}

Canvas paint_paving(int side, Random& random) {
  Canvas canvas(side);
  canvas.masonry(random, 6, 8, 0.008, {165, 160, 152}, {75, 72, 70}, 0.28, true);
  canvas.mottle(random, 0.14, 2, 8, 0.8);
  canvas.speckle(random, 500, 0.002, 0.012, 0.4, 1.4);
  for (int i = 0; i < 5; ++i) crack(canvas, random, 0.2, 0.005, {60, 58, 55});
  return canvas;
}

Canvas paint_roof(int side, Random& random) {
  Canvas canvas(side);
  const Paint tile = random.chance(0.5) ? Paint{150, 70, 50} : Paint{85, 85, 95};
  canvas.masonry(random, 12, 12, 0.01, tile, scaled(tile, 0.4), 0.3, true);
  canvas.mottle(random, 0.2, 2, 7, 0.8);
  return canvas;
}

Canvas paint_leaves(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill({30, 50, 25});
  const double hue = random.uniform(0.6, 1.4);
  for (int i = 0; i < 1500; ++i) {
    const double shade = random.uniform(0.35, 1.7);
    const Paint leaf = {static_cast<float>(75 * hue * shade), static_cast<float>(115 * shade),
                        static_cast<float>(45 * shade)};
    canvas.disc(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0.006, 0.026), leaf);
  }
  canvas.mottle(random, 0.3, 1, 3, 0.7);
  return canvas;
}

Canvas paint_bark(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill({95, 75, 55});
  for (int i = 0; i < 300; ++i) {
    const double x = random.uniform(0, 1);
    const double y = random.uniform(0, 1);
    canvas.stroke(x, y, x + random.uniform(-0.03, 0.03), y + random.uniform(0.05, 0.2),
                  random.uniform(0.008, 0.03), scaled({95, 75, 55}, random.uniform(0.3, 1.7)));
  }
  canvas.speckle(random, 40, 0.01, 0.05, 0.4, 1.8);
  return canvas;
}

Canvas paint_planks(int side, Random& random) {
  Canvas canvas(side);
  const Paint wood = scaled({150, 115, 75}, random.uniform(0.6, 1.3));
  canvas.masonry(random, 12, 1, 0.012, wood, scaled(wood, 0.25), 0.3, false);
  for (int i = 0; i < 260; ++i) {
    const double x = random.uniform(0, 1);
    const double y = random.uniform(0, 1);
    canvas.stroke(x, y, x, y + random.uniform(0.03, 0.2), 0.004, scaled(wood, random.uniform(0.5, 1.25)));
  }
  canvas.speckle(random, 160, 0.004, 0.014, 0.25, 0.7);
  for (const double y : {0.2, 0.75}) {
    canvas.rectangle(0.0, y, 1.0, 0.05, scaled(wood, 0.7));
    for (int i = 0; i < 24; ++i) canvas.disc((i + 0.5) / 24.0, y + 0.025, 0.007, {40, 40, 40});
  }
  canvas.mottle(random, 0.15, 1, 4, 0.8);
  return canvas;
}

Canvas paint_steel(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill(scaled({150, 155, 160}, random.uniform(0.5, 1.2)));
  for (int i = 0; i < 5; ++i)
    canvas.rectangle(0.0, random.uniform(0, 1), 1.0, random.uniform(0.02, 0.1),
                     random_paint(random, 20, 240));
  canvas.speckle(random, 150, 0.006, 0.03, 0.4, 1.5);
  for (int i = 0; i < 14; ++i) {
    canvas.rectangle(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0.05, 0.16),
                     random.uniform(0.03, 0.1), random_paint(random, 10, 250));
  }
  canvas.mottle(random, 0.15, 2, 6, 0.8);
  return canvas;
}

Canvas paint_bodywork(int side, Random& random) {
  Canvas canvas(side);
  const Paint paint = random_paint(random, 40, 230);
  canvas.fill(paint);
  const Paint seam = scaled(paint, 0.35);
  for (const double x : {0.08, 0.45, 0.82}) {
    canvas.rectangle(x, 0.0, 0.006, 1.0, seam);
    canvas.rectangle(x + 0.25, 0.12, 0.06, 0.02, seam);  // handle
  }
  canvas.rectangle(0.0, 0.28, 1.0, 0.03, contrasting(random, paint));
  lettering(canvas, random, random.uniform(0.0, 0.3), 0.08, 0.1, 6 + random.below(4),
            contrasting(random, paint));
  for (int i = 0; i < 10; ++i) {
    canvas.rectangle(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0.01, 0.08),
                     random.uniform(0.01, 0.06), random_paint(random, 10, 250));
  }
  canvas.speckle(random, 160, 0.003, 0.014, 0.5, 1.4);
  canvas.mottle(random, 0.18, 1, 5, 0.8);
  return canvas;
}

Canvas paint_tyre(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill({28, 28, 30});
  canvas.disc(0.5, 0.5, 0.34, {170, 172, 178});
  const double first = random.uniform(0.0, 1.0);
  for (int i = 0; i < 5; ++i) {
    const double angle = first + 2.0 * std::numbers::pi * i / 5.0;
    canvas.disc(0.5 + 0.2 * std::cos(angle), 0.5 + 0.2 * std::sin(angle), 0.08, {40, 40, 45});
  }
  canvas.disc(0.5, 0.5, 0.06, {60, 60, 66});
  canvas.speckle(random, 200, 0.005, 0.02, 0.6, 1.4);
  return canvas;
}

Canvas paint_glass(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill({60, 70, 82});
  for (int i = 0; i < 12; ++i) {
    canvas.rectangle(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0.05, 0.4),
                     random.uniform(0.05, 0.3), scaled({70, 80, 92}, random.uniform(0.4, 1.9)));
  }
  canvas.speckle(random, 80, 0.006, 0.03, 0.6, 1.6);
  return canvas;
}

Canvas paint_parquet(int side, Random& random) {
  Canvas canvas(side);
  canvas.masonry(random, 4, 16, 0.004, {150, 105, 65}, {60, 40, 25}, 0.35, true);
  for (int i = 0; i < 500; ++i) {
    const double x = random.uniform(0, 1);
    const double y = random.uniform(0, 1);
    canvas.stroke(x, y, x + random.uniform(0.01, 0.08), y, 0.004,
                  scaled({150, 105, 65}, random.uniform(0.5, 1.3)));
  }
  canvas.speckle(random, 300, 0.003, 0.012, 0.3, 1.6);
  canvas.mottle(random, 0.15, 1, 6, 0.8);
  return canvas;
}

Canvas paint_wallpaper(int side, Random& random) {
  Canvas canvas(side);
  const Paint paper = random_paint(random, 150, 220);
  canvas.fill(paper);
  // Sprigs in rows, each of its own size and shade: a pattern, but no two places in it are equal.
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      const double x = (column + (row % 2) * 0.5 + random.uniform(-0.25, 0.25)) / 9.0;
      const double y = (row + 0.5 + random.uniform(-0.25, 0.25)) / 9.0;
      const Paint ink = scaled(paper, random.uniform(0.3, 0.75));
      const double reach = random.uniform(0.012, 0.035);
      canvas.stroke(x - reach, y, x + reach, y, 0.012, ink);
      canvas.stroke(x, y - reach, x, y + reach, 0.012, ink);
      canvas.disc(x + reach, y - reach, 0.35 * reach, scaled(ink, 0.6));
    }
  }
  canvas.speckle(random, 350, 0.002, 0.012, 0.6, 1.25);
  canvas.mottle(random, 0.1, 2, 7, 0.9);
  return canvas;
}

Canvas paint_wood(int side, Random& random) {
  Canvas canvas(side);
  const Paint wood = scaled({165, 120, 75}, random.uniform(0.6, 1.2));
  canvas.fill(wood);
  for (int i = 0; i < 260; ++i) {
    const double x = random.uniform(0, 1);
    const double y = random.uniform(0, 1);
    canvas.stroke(x, y, x + random.uniform(0.05, 0.3), y + random.uniform(-0.01, 0.01), 0.006,
                  scaled(wood, random.uniform(0.5, 1.35)));
  }
  canvas.speckle(random, 90, 0.006, 0.03, 0.3, 0.8);
  return canvas;
}

Canvas paint_carton(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill(scaled({170, 130, 85}, random.uniform(0.7, 1.2)));
  canvas.mottle(random, 0.2, 1, 6, 0.8);
  canvas.rectangle(0.44, 0.0, 0.12, 1.0, {200, 170, 110});
  for (int i = 0; i < 5; ++i) {
    const double x = random.uniform(0.02, 0.6);
    const double y = random.uniform(0.02, 0.7);
    canvas.rectangle(x, y, random.uniform(0.15, 0.36), random.uniform(0.1, 0.25),
                     random_paint(random, 120, 250));
    lettering(canvas, random, x + 0.02, y + 0.03, 0.06, 4, {20, 20, 30});
  }
  lettering(canvas, random, 0.08, random.uniform(0.1, 0.8), 0.12, 8, {30, 25, 20});
  canvas.speckle(random, 120, 0.004, 0.016, 0.4, 1.4);
  return canvas;
}

Canvas paint_books(int side, Random& random) {
  Canvas canvas(side);
  canvas.fill({45, 32, 22});
  for (int row = 0; row < 3; ++row) {
    for (double x = 0.0; x < 0.985;) {
      const double width = std::min(random.uniform(0.018, 0.06), 1.0 - x);
      const double height = random.uniform(0.2, 0.29);
      const Paint spine = random_paint(random, 20, 230);
      const double top = (row + 1) / 3.0 - 0.03 - height;
      if (!random.chance(0.06)) {
        canvas.rectangle(x, top, width - 0.003, height, spine);
        canvas.rectangle(x, top + random.uniform(0.02, 0.1), width - 0.003, 0.02, contrasting(random, spine));
        canvas.rectangle(x + 0.2 * width, top + random.uniform(0.12, 0.18), 0.5 * width, 0.05,
                         contrasting(random, spine));
      }
      x += width;
    }
    canvas.rectangle(0.0, (row + 1) / 3.0 - 0.03, 1.0, 0.03, {140, 100, 60});
  }
  canvas.mottle(random, 0.15, 2, 6, 0.8);
  return canvas;
}

Canvas paint_tiles(int side, Random& random) {
  Canvas canvas(side);
  canvas.masonry(random, 4, 4, 0.012, {205, 205, 200}, {110, 110, 110}, 0.1, false);
  canvas.speckle(random, 1200, 0.002, 0.008, 0.35, 0.85);
  canvas.mottle(random, 0.1, 1, 6, 0.8);
  return canvas;
}

Canvas paint_facade(int side, Random& random, const Facade& facade) {
  Canvas canvas(side);
  paint_wall(canvas, random);
  const Paint frame = random.chance(0.5) ? random_paint(random, 200, 250) : random_paint(random, 20, 90);
  const Paint band = random_paint(random, 60, 220);
  const int style = random.below(12);
  canvas.rectangle(0.0, 0.93, 1.0, 0.07, scaled(band, 0.6));  // plinth
  if (random.chance(0.6)) canvas.rectangle(0.0, 0.49, 1.0, 0.02, band);
  canvas.rectangle(0.0, 0.0, 1.0, 0.03, scaled(band, 0.8));  // eaves
  const double pitch = 1.0 / facade.windows;
  const double width = std::min(0.5 * pitch, random.uniform(0.12, 0.2));
  const int door_column = facade.has_door ? random.below(facade.windows) : -1;
  for (int storey = 0; storey < facade.storeys; ++storey) {
    const double storey_height = 0.9 / facade.storeys;
    for (int column = 0; column < facade.windows; ++column) {
      const double x = (column + 0.5) * pitch - 0.5 * width;
      const double y = 0.05 + storey * storey_height + 0.2 * storey_height;
      if (storey + 1 == facade.storeys && column == door_column) {
        door(canvas, random, x, 1.0 - 0.38 * (facade.storeys == 1 ? 1.6 : 1.0), 0.16, frame);
      } else {
        window(canvas, random, x, y, width, std::min(0.55 * storey_height, 0.3), frame, style);
      }
    }
  }
  const int pipes = random.below(3);
  for (int i = 0; i < pipes; ++i) {  // rain pipes
    const double x = random.uniform(0.01, 0.97);
    canvas.rectangle(x, 0.0, 0.012, 1.0, scaled(frame, 0.7));
    for (double y = 0.05; y < 1.0; y += 0.13) canvas.rectangle(x - 0.006, y, 0.024, 0.008, {40, 40, 40});
  }
  if (random.chance(0.6)) {
    lettering(canvas, random, random.uniform(0.05, 0.4), 0.485, 0.045, 6 + random.below(8),
              random_paint(random, 0, 255));
  }
  for (int i = 0; i < 8; ++i) {  // damp, spray paint
    const double x = random.uniform(0, 1);
    const double y = random.uniform(0.55, 0.95);
    canvas.stroke(x, y, x + random.uniform(-0.08, 0.08), y + random.uniform(-0.05, 0.05), 0.008,
                  random_paint(random, 0, 255));
  }
  canvas.speckle(random, 250, 0.002, 0.012, 0.45, 1.4);
  return canvas;
}

Canvas paint_posters(int side, Random& random) {
  Canvas canvas(side);
  for (int i = 0; i < kPostersOnSheet; ++i) {
    const Patch patch = poster_patch(i);
    poster(canvas, random, patch.u, patch.v, patch.width);
  }
  return canvas;
}

Patch poster_patch(int number) {
  constexpr int kAcross = 4;
  constexpr double kSize = 1.0 / kAcross;
  const int row = number / kAcross;
  return {kSize * (number % kAcross), kSize * row, kSize, kSize};
}

}  // namespace covey::sim
