// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lcd/options.h"

#include <catch2/catch.hpp>

#include "tests/core/pgo/scratch.h"

namespace covey {
namespace {

Rig rover() { return read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/sensors/rover.yaml"); }

LcdNodeOptions read(const std::string& text, const Rig& rig) {
  Config config = Config::parse(text, "lcd.yaml");
  const LcdNodeOptions options = read_lcd_options(config.root().section("lcd"), rig);
  config.check_all_read();
  return options;
}

TEST_CASE("pixels of RANSAC become directions by the rig") {
  const Rig rig = rover();
  const auto options = read("lcd: {vocabulary: v.bin, ransac_px: 2, view_px: 1, disparity_px: 0.25}", rig);
  const double focal = rig.left.camera.fx;
  REQUIRE(options.vocabulary == "v.bin");
  REQUIRE(options.agent.verification.ransac_direction == Approx(2.0 / focal));
  REQUIRE(options.features.view_px == 1.0);
  REQUIRE(options.features.disparity_px == 0.25);
}

TEST_CASE("keys are read, with units and ranges, and mistakes are named") {
  const auto options =
      read("lcd: {vocabulary: v.bin, features: 300, recent_s: 4, candidates: 3, least_inliers: 20}", rover());
  REQUIRE(options.features.orb.features == 300);
  REQUIRE(options.agent.recent_us == 4'000'000);
  REQUIRE(options.agent.candidates == 3);
  REQUIRE(options.agent.verification.least_inliers == 20);
  const auto error = [](const std::string& text, const Rig& rig) {
    return input_error_of([&] { read(text, rig); });
  };
  REQUIRE_THAT(error("lcd: {}", rover()), Catch::Matchers::Contains("vocabulary"));
  REQUIRE_THAT(error("lcd: {vocabulary: v, least_inliers: 3}", rover()),
               Catch::Matchers::Contains("least_inliers"));
  REQUIRE_THAT(error("lcd: {vocabulary: v, no_such: 3}", rover()), Catch::Matchers::Contains("no_such"));
  Rig single = rover();
  single.right.reset();
  REQUIRE_THAT(error("lcd: {vocabulary: v}", single), Catch::Matchers::Contains("right camera"));
}

}  // namespace
}  // namespace covey
