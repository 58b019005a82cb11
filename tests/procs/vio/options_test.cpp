// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/options.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

using namespace covey;

namespace {

VioProcessOptions read(const std::string& text) {
  Config config = Config::parse(text, "robot.yaml");
  VioProcessOptions options = read_vio_process_options(config.root().section("vio"));
  config.check_all_read();
  return options;
}

}  // namespace

TEST_CASE("the section vio says where odometry comes from and how it is made") {
  CHECK(read("").source == VioSource::kImages);
  const VioProcessOptions options =
      read("vio: {source: odometry, window: 8, front_end: {tracks: 120}, odometry: {sigma_m: 0.1}}");
  CHECK(options.source == VioSource::kExternal);
  CHECK(options.estimator.window == 8);
  CHECK(options.front_end.tracks == 120);
  CHECK(options.odometry.sigma_m == 0.1);
}

TEST_CASE("what the section vio cannot mean is refused in words") {
  CHECK(input_error_of([] { read("vio: {source: lidar}"); }) ==
        "robot.yaml:1: key 'vio.source': 'lidar' is neither images nor odometry");
  CHECK(input_error_of([] { read("vio: {front_end: {window_px: 20}}"); }) ==
        "robot.yaml:1: key 'vio.front_end.window_px': 20 is even; a window has a pixel in its middle");
  CHECK_FALSE(input_error_of([] { read("vio: {front_end: {trakcs: 20}}"); }).empty());
}
