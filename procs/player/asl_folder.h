// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A recording in the layout of the EuRoC datasets (ASL): DIR/mav0 or DIR itself holds cam0, cam1 and imu0, each with a data.csv of stamps in nanoseconds
// (lines that begin with # are comments); pictures are in cam<i>/data under the names that data.csv gives. Left and right belong together where their stamps
// are equal (sequences MH_04 and V2_03 have different counts); a left picture without a partner goes alone, a right one is left out.
// cam1 may be missing as a whole, and so may imu0.
//
// InputError that names file and line: a file that cannot be opened, a line that cannot be read, stamps that do not increase, a picture that is not there.

#include <covey/imu_t.hpp>
#include <covey/stereo_t.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace covey {

struct AslPicture {
  Utime utime = 0;
  std::filesystem::path left;
  std::filesystem::path right;  // empty: none
  std::string listed;           // "data.csv:12", of the left one
};

struct AslFolder {
  std::vector<imu_t> imu;
  std::vector<AslPicture> pictures;
  int unpaired_left = 0;
  int unpaired_right = 0;
};

AslFolder read_asl(const std::filesystem::path& folder);

// Decoded to grey. InputError where a picture cannot be read or the two differ in size.
stereo_t load_stereo(const AslPicture& picture);

}  // namespace covey
