// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Visual-inertial odometry from IMU and STEREO: front end (core/vision), then estimator (core/vio). A picture is worked on as soon as an IMU sample of its time or
// later is there; where none comes the newest few wait for it, and what is older goes on without.

#include <deque>
#include <string>

#include "core/vio/estimator.h"
#include "core/vision/stereo_front_end.h"
#include "procs/common/process.h"
#include "procs/vio/frame_log.h"
#include "procs/vio/options.h"
#include "procs/vio/output.h"

namespace covey {

class ImageSource {
 public:
  ImageSource(Process& process, const VioProcessOptions& options, VioOutput& output,
              const std::filesystem::path& frames);

 private:
  void on_imu(const imu_t& message);
  void on_stereo(const stereo_t& message);
  void work();
  void go_without_imu();
  void process(const stereo_t& message);
  void take(const vio::VioFrame& frame);
  void drop(Utime utime, const char* reason);

  Process& process_;
  VioOutput& output_;
  FrameLog frames_;
  StereoFrontEnd front_end_;
  vio::VioEstimator estimator_;
  std::deque<stereo_t> waiting_;
  Utime last_frame_ = 0;
  std::string trouble_;  // that was last told
};

}  // namespace covey
