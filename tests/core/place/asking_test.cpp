// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/asking.h"

#include <catch2/catch.hpp>

namespace covey::place {
namespace {

constexpr Utime kSecond = kUsPerSecond;
const AskingOptions kOptions{.per_keyframe = 0.5, .at_once = 3, .again_us = kSecond, .times = 3};

KeyframeName of(int robot, int id) { return {robot, 7, id}; }
bool in_range(int /*robot*/) { return true; }

TEST_CASE("a robot is asked for so many at once, and then for a share of what is heard of it") {
  Asking asking(0, kOptions);
  REQUIRE(asking.ask(of(1, 0), 0));
  REQUIRE_FALSE(asking.ask(of(1, 0), 0));  // it is asked for
  REQUIRE(asking.ask(of(1, 1), 0));
  REQUIRE(asking.ask(of(2, 0), 0));
  REQUIRE(asking.ask(of(1, 2), 0));
  asking.allow(1);
  asking.allow(1);
  REQUIRE_FALSE(asking.ask(of(1, 3), 0));  // three are open
  const auto questions = asking.take(5);
  REQUIRE(questions.size() == 2);  // one to each robot
  const auto& request = std::get<lcd_request_t>(questions[0]);
  REQUIRE(request.from == 0);
  REQUIRE(request.to == 1);
  REQUIRE(request.utime == 5);
  REQUIRE(request.ids == std::vector<std::int32_t>{0, 1, 2});
  REQUIRE(request.segments == std::vector<std::int64_t>{7, 7, 7});
  REQUIRE(asking.take(5).empty());

  REQUIRE(asking.known(of(1, 1)) == 0);
  asking.end(of(1, 1));
  REQUIRE_FALSE(asking.known(of(1, 1)).has_value());
  asking.end(of(1, 2));
  REQUIRE(asking.ask(of(1, 3), 0));        // two that were heard of
  REQUIRE_FALSE(asking.ask(of(1, 4), 0));  // pay for one
}

TEST_CASE("who does not answer is asked again, ever later, and given up") {
  Asking asking(0, kOptions);
  asking.ask(of(1, 0), 0);
  asking.take(0);
  REQUIRE(asking.waits(in_range));
  int said = 0;
  std::vector<Utime> times;
  for (Utime now = 0; now <= 20 * kSecond; now += kSecond / 4) {
    const auto given_up = asking.give_up(now, in_range);
    for (const auto& question : asking.take(now)) {
      REQUIRE(std::get<lcd_request_t>(question).ids == std::vector<std::int32_t>{0});
      times.push_back(now);
    }
    if (given_up.empty()) continue;
    ++said;
    REQUIRE(given_up == std::vector<KeyframeName>{of(1, 0)});
    times.push_back(now);
  }
  REQUIRE(said == 1);
  REQUIRE(times == std::vector<Utime>{kSecond, 3 * kSecond, 7 * kSecond});
  REQUIRE_FALSE(asking.known(of(1, 0)).has_value());
}

TEST_CASE("nothing is asked of who is away, and everything anew of who comes back") {
  Asking asking(0, kOptions);
  asking.ask(of(1, 0), 0);
  asking.take(0);
  const auto away = [](int robot) { return robot != 1; };
  REQUIRE_FALSE(asking.waits(away));
  for (Utime now = 0; now <= 60 * kSecond; now += kSecond) {
    REQUIRE(asking.give_up(now, away).empty());
    REQUIRE(asking.take(now).empty());
  }
  asking.hear(1, 60 * kSecond);
  REQUIRE(asking.give_up(60 * kSecond, in_range).empty());
  REQUIRE(asking.take(60 * kSecond).empty());
  REQUIRE(asking.give_up(61 * kSecond, in_range).empty());
  REQUIRE(asking.take(61 * kSecond).size() == 1);
}

TEST_CASE("more of a keyframe is asked for once, for the price of two") {
  Asking asking(0, kOptions);
  REQUIRE(asking.ask_for_more(of(1, 0), 150, 0));
  REQUIRE_FALSE(asking.ask_for_more(of(1, 1), 150, 0));  // one is left of three
  const auto questions = asking.take(0);
  REQUIRE(questions.size() == 1);
  REQUIRE(std::get<lcd_more_t>(questions[0]).known == 150);
  REQUIRE(std::get<lcd_more_t>(questions[0]).to == 1);
  REQUIRE(asking.known(of(1, 0)) == 150);
  REQUIRE(asking.give_up(kSecond, in_range).empty());
  REQUIRE(std::holds_alternative<lcd_more_t>(asking.take(kSecond).at(0)));
  asking.end(of(1, 0));
  for (int k = 0; k < 6; ++k) asking.allow(1);
  REQUIRE_FALSE(asking.ask_for_more(of(1, 0), 150, 0));
  asking.forget(of(1, 0));
  REQUIRE(asking.ask_for_more(of(1, 0), 150, 0));
}

}  // namespace
}  // namespace covey::place
