// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Poses with stamps, and the text format of the TUM benchmarks: one pose a line, `t tx ty tz qx qy qz qw`
// with t in seconds, lines that are empty or begin with # are comments. Stamps are rounded to microseconds on
// reading and written with six decimals, so writing and reading returns the same utime. Reading refuses a
// file that cannot be opened, a line that is not eight finite numbers, a zero quaternion and stamps that do
// not increase, naming file and line (InputError).

#include <filesystem>
#include <vector>

#include "core/base/time.h"
#include "core/geometry/se3.h"

namespace covey {

struct StampedPose {
  Utime utime = 0;
  SE3 pose;
};
using Trajectory = std::vector<StampedPose>;

Trajectory read_tum(const std::filesystem::path& file);
void write_tum(const std::filesystem::path& file, const Trajectory& trajectory);

}  // namespace covey
