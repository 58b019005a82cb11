// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A keyframe with what truth knows of it.

#include <map>

#include "core/base/time.h"
#include "core/geometry/se3.h"
#include "core/place/lcd_messages.h"

namespace covey::bench {

struct View {
  place::KeyframeName name;
  Utime utime = 0;
  SE3 T_W_B;
};

using Views = std::map<place::KeyframeName, View>;

}  // namespace covey::bench
