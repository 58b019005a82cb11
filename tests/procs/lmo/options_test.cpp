// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lmo/options.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

namespace covey {

TEST_CASE("lmo's options are read, and what is outside their range is refused") {
  Config config =
      Config::parse("lmo: {cell_m: 0.5, max_nodes: 900, pass_s: 12, settle_s: 0.5}", "robot.yaml");
  const LmoOptions options = read_lmo_options(config.root().section("lmo"));
  config.check_all_read();
  REQUIRE(options.deformation.simplify.min_cell_m == 0.5);
  REQUIRE(options.deformation.simplify.max_nodes == 900);
  REQUIRE(options.deformation.simplify.pass_us == 12'000'000);
  REQUIRE(options.settle_us == 500'000);
  REQUIRE(options.patience_us == LmoOptions{}.patience_us);
  Config bad = Config::parse("lmo: {cell_m: -1}", "robot.yaml");
  REQUIRE(input_error_of([&] { read_lmo_options(bad.root().section("lmo")); }).find("cell_m") !=
          std::string::npos);
}

}  // namespace covey
