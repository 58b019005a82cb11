// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// PNG, written by libpng: 8-bit RGB, no time stamp, so that equal pictures are equal files.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "viewer_offscreen/image.h"

namespace covey::viewer {

std::vector<std::uint8_t> encode_png(const Image& image);

// Replaces the file in one step: a reader sees the old picture or the new one. InputError where it cannot be
// written.
void write_png(const std::filesystem::path& file, const Image& image);

}  // namespace covey::viewer
