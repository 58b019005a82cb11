// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The robot's odometry, wired to its buses.
//
//   reads   IMU, STEREO, or ODOMETRY with `source: odometry` (sensor bus)
//   writes  STATE (each IMU sample, or each ODOMETRY), KEYFRAME (stream); at the end the --tum file; STATUS
//
// STATUS: README.md lists phases, gauges and counters.

#include <filesystem>
#include <memory>

#include "procs/common/process.h"
#include "procs/vio/image_source.h"
#include "procs/vio/odometry_source.h"
#include "procs/vio/output.h"

namespace covey {

class VioNode {
 public:
  // frames: of --frames; empty where not given.
  VioNode(Process& process, const std::filesystem::path& frames);

 private:
  VioOutput output_;
  std::unique_ptr<ImageSource> images_;  // one of the two
  std::unique_ptr<OdometrySource> odometry_;
};

}  // namespace covey
