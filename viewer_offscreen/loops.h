// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Loop closures for a figure, from text: one a line, `x0 y0 z0 x1 y1 z1 status` in W and metres, with commas
// or blanks between, status one of accepted, rejected, true, false. Empty lines, lines that begin with # and
// a first line of column names (beginning with x0) are read over. InputError names file and line.

#include <filesystem>
#include <vector>

#include "viewer_offscreen/figure.h"

namespace covey::viewer {

std::vector<LoopLine> read_loops(const std::filesystem::path& file);

}  // namespace covey::viewer
