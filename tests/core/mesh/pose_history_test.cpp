// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/pose_history.h"

#include <catch2/catch.hpp>

using namespace covey;
using namespace covey::mesh;

namespace {

TimedPose at_x(Utime utime, double x, std::int64_t segment = 1) {
  return {utime, segment, {{}, {x, 0, 0}}, false};
}

}  // namespace

TEST_CASE("Poses are interpolated at the stamp, once a later one is known") {
  PoseHistory history;
  CHECK(history.add(at_x(1'000'000, 1.0)));
  TimedPose found;
  CHECK(history.at(1'002'000, found) == PoseLookup::kNotYet);
  CHECK(history.add(at_x(1'005'000, 2.0)));
  CHECK(history.at(1'002'000, found) == PoseLookup::kFound);
  CHECK(found.T_O_B.translation.x() == Approx(1.4));
  CHECK(found.utime == 1'002'000);
  CHECK(history.at(1'005'000, found) == PoseLookup::kFound);
  CHECK(found.T_O_B.translation.x() == 2.0);
  CHECK(history.at(999'999, found) == PoseLookup::kTooOld);
  CHECK_FALSE(history.add(at_x(1'005'000, 3.0)));
}

TEST_CASE("Poses are not interpolated over gaps, segments or coasting") {
  PoseHistory history;
  history.add(at_x(1'000'000, 1.0));
  history.add(at_x(1'200'000, 2.0));
  history.add(at_x(1'205'000, 2.0, 2));
  TimedPose coasting = at_x(1'210'000, 3.0, 2);
  coasting.coasting = true;
  history.add(coasting);
  TimedPose found;
  CHECK(history.at(1'100'000, found) == PoseLookup::kGap);
  CHECK(history.at(1'202'000, found) == PoseLookup::kGap);
  CHECK(history.at(1'207'000, found) == PoseLookup::kCoasting);
  CHECK(history.at(1'210'000, found) == PoseLookup::kCoasting);
}

TEST_CASE("A few seconds of poses are kept, and a segment that begins earlier replaces all") {
  PoseHistory history({.length_s = 1.0});
  for (int i = 0; i < 1000; ++i) history.add(at_x(5'000 * i, i));
  TimedPose found;
  CHECK(history.at(3'900'000, found) == PoseLookup::kTooOld);
  CHECK(history.at(4'100'000, found) == PoseLookup::kFound);
  CHECK(history.add(at_x(1'000'000, 0.0, 9)));
  CHECK(history.add(at_x(1'005'000, 1.0, 9)));
  CHECK(history.at(1'001'000, found) == PoseLookup::kFound);
  CHECK(found.segment == 9);
  CHECK(history.at(4'100'000, found) == PoseLookup::kNotYet);
}
