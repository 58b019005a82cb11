// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Section `lcd` of a robot's configuration; README.md has the keys.

#include <string>

#include "core/base/config.h"
#include "core/geometry/rig.h"
#include "core/place/lcd_agent.h"
#include "core/place/stereo_features.h"

namespace covey {

struct LcdNodeOptions {
  std::string vocabulary;  // file, relative to the configuration
  place::StereoFeatureOptions features;
  place::LcdOptions agent;
};

// The rig turns pixels into directions and depths. Throws InputError, also where the rig has no right camera.
LcdNodeOptions read_lcd_options(ConfigSection& section, const Rig& rig);

}  // namespace covey
