// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/funnel.h"

#include <catch2/catch.hpp>

namespace covey::place {
namespace {

TEST_CASE("steps and reasons are counted for each robot, and summed") {
  Funnel funnel;
  REQUIRE(funnel.total().empty());
  funnel.count(1, "received");
  funnel.count(1, "received");
  funnel.count(2, "received");
  funnel.refuse(2, "gone", 3);
  funnel.refuse(1, "gone", 1);
  REQUIRE(funnel.by_robot().at(1) == Funnel::Counts{{"received", 2}, {"refused/gone", 1}});
  REQUIRE(funnel.by_robot().at(2) == Funnel::Counts{{"received", 1}, {"refused/gone", 3}});
  REQUIRE(funnel.total() == Funnel::Counts{{"received", 3}, {"refused/gone", 4}});
}

}  // namespace
}  // namespace covey::place
