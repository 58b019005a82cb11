// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/options.h"

namespace covey {

VioProcessOptions read_vio_process_options(ConfigSection& section) {
  VioProcessOptions options;
  std::string source = "images";
  section.read("source", source);
  if (source != "images" && source != "odometry") {
    throw_input_error("{}: '{}' is neither images nor odometry", section.where("source"), source);
  }
  options.source = source == "images" ? VioSource::kImages : VioSource::kExternal;
  options.estimator = vio::read_vio_options(section);
  options.front_end = read_front_end_options(section.section("front_end"));
  options.odometry = vio::read_external_odometry_options(section.section("odometry"));
  return options;
}

}  // namespace covey
