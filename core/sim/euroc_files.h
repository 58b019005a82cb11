// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The motion of a EuRoC sequence as it was recorded (Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016): its IMU's samples
// and its ground truth, the pose T_W_B of the IMU. Files may be gzipped. The ground truth is read in both forms that are about: EuRoC's
// columns (stamp in ns, p, q as w x y z, and more, separated by commas), and TUM's (stamp in s, p, q as x y z w, separated by spaces).
// InputError that names file and line where a line cannot be read, stamps do not increase, or nothing is there.

#include <filesystem>
#include <vector>

#include "core/geometry/trajectory.h"
#include "core/imu/state.h"

namespace covey::sim {

std::vector<ImuSample> read_euroc_imu(const std::filesystem::path& file);
Trajectory read_euroc_truth(const std::filesystem::path& file);

struct EurocSequence {
  std::vector<ImuSample> imu;
  Trajectory truth;
};

// FOLDER/{imu0,groundtruth}.csv.gz
EurocSequence read_euroc_sequence(const std::filesystem::path& folder);

}  // namespace covey::sim
