// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/config.h"
#include "core/vio/external_odometry.h"
#include "core/vio/options.h"
#include "core/vision/stereo_front_end.h"

namespace covey {

enum class VioSource { kImages, kExternal };

struct VioProcessOptions {
  VioSource source = VioSource::kImages;
  vio::VioOptions estimator;
  FrontEndOptions front_end;
  vio::ExternalOdometryOptions odometry;
};

// Section `vio` of the configuration; procs/vio/README.md explains the keys.
VioProcessOptions read_vio_process_options(ConfigSection& section);

}  // namespace covey
