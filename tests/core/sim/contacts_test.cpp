// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/contacts.h"

#include <catch2/catch.hpp>

namespace covey::sim {
namespace {

Motion along_x(double x0, double speed, double y) {
  return {0, 40'000'000, [=](Utime t) {
            MotionState state;
            state.T_W_B.translation = {x0 + speed * to_seconds(t), y, 0.0};
            return state;
          }};
}

const Eigen::AlignedBox3d kHouse(Eigen::Vector3d(-5.0, 4.0, 0.0), Eigen::Vector3d(5.0, 6.0, 8.0));

TEST_CASE("a box is between two points where the line between them goes through it") {
  CHECK(is_between(kHouse, {0, 0, 1}, {0, 10, 1}));
  CHECK(is_between(kHouse, {0, 5, 1}, {0, 10, 1}));
  CHECK(is_between(kHouse, {-20, 5, 1}, {20, 5, 1}));
  CHECK_FALSE(is_between(kHouse, {0, 0, 1}, {0, 3, 1}));
  CHECK_FALSE(is_between(kHouse, {0, 0, 9}, {0, 10, 9}));
  CHECK_FALSE(is_between(kHouse, {6, 0, 1}, {6, 10, 1}));
  CHECK_FALSE(is_between(kHouse, {0, 7, 1}, {0, 10, 1}));
}

TEST_CASE("radios hear each other within range, farther in the open than behind a house") {
  // One stands; the other drives past it at y = 10, from x = -20 at 1 m/s.
  const std::vector<Motion> motions = {along_x(0.0, 0.0, 0.0), along_x(-20.0, 1.0, 10.0)};
  const ContactOptions options{.range_m = 20.0, .range_behind_m = 8.0, .antenna_m = 0.5, .step_s = 0.25};
  const auto open = find_contacts(motions, {}, options);
  REQUIRE(open.size() == 2);
  const double reach = std::sqrt(20.0 * 20.0 - 10.0 * 10.0);
  CHECK(open[0].a == 0);
  CHECK(open[0].b == 1);
  CHECK(open[0].from_s == Approx(20.0 - reach).margin(0.25));
  CHECK(open[0].until_s == Approx(20.0 + reach).margin(0.25));
  CHECK(open[1].from_s == 40.0);  // the end, where the team comes together
  CHECK(open[1].until_s > 1e5);

  // The house hides it while the line to it crosses y = 4 ... 6 within |x| < 5, that is |x| < 12.5.
  const auto hidden = find_contacts(motions, {kHouse}, options);
  REQUIRE(hidden.size() == 3);
  CHECK(hidden[0].until_s == Approx(20.0 - 12.5).margin(0.25));
  CHECK(hidden[1].from_s == Approx(20.0 + 12.5).margin(0.25));
}

TEST_CASE("the radio's simulation reads the plan back") {
  const std::vector<radio::Contact> plan = {{0, 1, 0.0, 12.25}, {0, 1, 30.5, 1e6}, {1, 2, 45.0, 1e6}};
  Config config = Config::parse(format_contacts(plan), "contacts.yaml");
  const radio::LinkModelOptions read = radio::read_link_model(config.root().section("radio_bridge"));
  config.check_all_read();
  REQUIRE(read.contacts.has_value());
  REQUIRE(read.contacts->size() == plan.size());
  for (std::size_t k = 0; k < plan.size(); ++k) {
    CHECK((*read.contacts)[k].a == plan[k].a);
    CHECK((*read.contacts)[k].b == plan[k].b);
    CHECK((*read.contacts)[k].from_s == plan[k].from_s);
    CHECK((*read.contacts)[k].until_s == plan[k].until_s);
  }
  Config none = Config::parse(format_contacts({}), "contacts.yaml");
  CHECK(radio::read_link_model(none.root().section("radio_bridge")).contacts->empty());
}

}  // namespace
}  // namespace covey::sim
