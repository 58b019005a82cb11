// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What labels are called and how they are painted: a JSON file of number -> name, e.g. {"0": "ground", "1": "road"}, or of
// number -> {"name": "kiosk", "colour": "#c04020"}. Classes with a customary name (road, tree, car, wall ...) are painted as one
// expects them, whatever their number; others as label_colour() has it.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "viewer_offscreen/colour.h"

namespace covey::viewer {

struct LabelClass {
  std::string name;
  Rgb colour;
};

using LabelClasses = std::map<std::uint16_t, LabelClass>;

// InputError names the file and the key.
LabelClasses read_label_classes(const std::filesystem::path& file);

// "label 7" for a class that is not named.
LabelClass label_class(const LabelClasses& classes, std::uint16_t label);

}  // namespace covey::viewer
