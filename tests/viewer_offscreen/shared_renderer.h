// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "viewer_offscreen/renderer.h"

namespace covey::viewer {

// One context for all tests of a process: to make one takes longer than to draw.
inline Renderer& shared_renderer() {
  static Renderer renderer;
  return renderer;
}

}  // namespace covey::viewer
