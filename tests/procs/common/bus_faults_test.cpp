// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/bus_faults.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace covey {
namespace {

TEST_CASE("Bus faults are read from one option, and nonsense is refused in words") {
  const BusFaults faults = parse_bus_faults("drop=0.1,duplicate=0.05,delay_ms=50,seed=7");
  CHECK(faults.drop == 0.1);
  CHECK(faults.duplicate == 0.05);
  CHECK(faults.delay_ms == 50.0);
  CHECK(faults.seed == 7);
  CHECK_FALSE(parse_bus_faults("").any());
  CHECK_THROWS_AS(parse_bus_faults("drop=1.5"), InputError);
  CHECK_THROWS_AS(parse_bus_faults("drop"), InputError);
  CHECK_THROWS_AS(parse_bus_faults("drop=0.1x"), InputError);
  CHECK_THROWS_WITH(parse_bus_faults("loss=0.1"), Catch::Contains("loss") && Catch::Contains("duplicate"));
}

TEST_CASE("Faults come with the rates that were asked for, and the same seed gives the same fate") {
  const BusFaults faults{.drop = 0.2, .duplicate = 0.1, .delay_ms = 50.0, .seed = 3};
  FaultInjector a(faults);
  FaultInjector b(faults);
  FaultInjector other({.drop = 0.2, .duplicate = 0.1, .delay_ms = 50.0, .seed = 4});
  int dropped = 0;
  int doubled = 0;
  int different = 0;
  double delay_sum_us = 0.0;
  constexpr int kMessages = 20'000;
  for (int i = 0; i < kMessages; ++i) {
    const auto delays = a.next("KEYFRAME");
    b.next("LOOP");  // what happens on one channel does not change another's luck
    REQUIRE(delays == b.next("KEYFRAME"));
    different += delays != other.next("KEYFRAME") ? 1 : 0;
    dropped += delays.empty() ? 1 : 0;
    doubled += delays.size() == 2 ? 1 : 0;
    for (const Utime delay : delays) {
      REQUIRE((delay >= 0 && delay <= 50'000));
      delay_sum_us += static_cast<double>(delay) / static_cast<double>(delays.size());
    }
  }
  CHECK(dropped == Approx(0.2 * kMessages).epsilon(0.05));
  CHECK(doubled == Approx(0.08 * kMessages).epsilon(0.1));
  CHECK(delay_sum_us / (kMessages - dropped) == Approx(25'000).epsilon(0.03));
  CHECK(different > kMessages / 2);
}

}  // namespace
}  // namespace covey
