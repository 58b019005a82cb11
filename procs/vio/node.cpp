// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/node.h"

#include "procs/vio/options.h"

namespace covey {

VioNode::VioNode(Process& process, const std::filesystem::path& frames) : output_(process) {
  const VioProcessOptions options = read_vio_process_options(process.config().root().section("vio"));
  if (options.source == VioSource::kImages) {
    images_ = std::make_unique<ImageSource>(process, options, output_, frames);
  } else {
    odometry_ = std::make_unique<OdometrySource>(process, options, output_);
  }
}

}  // namespace covey
