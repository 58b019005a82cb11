// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What every calibration file has, under whatever keys: sizes, intrinsics, a lens, poses. Each throws InputError that names file, line and key.

#include <string>
#include <vector>

#include "core/base/config.h"
#include "core/geometry/camera.h"
#include "core/geometry/se3.h"

namespace covey {

std::vector<double> read_numbers(ConfigSection& section, const std::string& key, std::size_t count);

void set_size(PinholeCamera& camera, int width, int height, const std::string& where);
// [fx, fy, cx, cy]
void read_intrinsics(ConfigSection& section, const std::string& key, PinholeCamera& camera);
// The model's name ("radial-tangential" or "radtan", "equidistant", "none") and its four coefficients; a file without them has no distortion.
void read_lens(ConfigSection& section, const std::string& model, const std::string& coefficients,
               PinholeCamera& camera);

// 16 numbers, row by row; calibrations are written with a few digits: to the nearest rotation, if one is near.
SE3 pose_from(const std::vector<double>& numbers, const std::string& where);

}  // namespace covey
