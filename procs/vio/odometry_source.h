// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Somebody else's odometry instead of images and IMU: the same STATE and KEYFRAME are cut from it (core/vio/external_odometry.h), so that nobody downstream
// can tell.

#include "core/vio/external_odometry.h"
#include "procs/common/process.h"
#include "procs/vio/options.h"
#include "procs/vio/output.h"

namespace covey {

class OdometrySource {
 public:
  OdometrySource(Process& process, const VioProcessOptions& options, VioOutput& output);

 private:
  void on_odometry(const odometry_t& message);
  void drop(const char* reason);

  Process& process_;
  VioOutput& output_;
  vio::ExternalOdometry odometry_;
};

}  // namespace covey
