// SPDX-License-Identifier: BSD-3-Clause
// Place recognition over radio_bridge's links, 1 Mbit/s with 100 ms delay and 10 % loss, when robots come into range: how soon the first
// closure is there, and that nothing is sent twice.

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <iostream>
#include <optional>

#include "tests/simnet/lcd_team.h"

namespace covey::place {
namespace {

constexpr double kMegabit = 125'000.0;  // bytes / s
constexpr LinkFaults kFaults{.loss = 0.1, .delay_us = 100'000};
constexpr Utime kApart = 300 * kSecond;

struct Meeting {
  std::optional<double> first_closure_s;  // from the meeting
  double backlog_s = 0.0;                 // until the verifier has all bags
};

// Robots 0 and 1 come into range now.
Meeting meet(Team& team, int verifier, Utime patience) {
  team.air().heal();
  const Utime met = team.now();
  const auto before = team.published(verifier).size();
  const int other = 1 - verifier;
  Meeting meeting;
  while (team.now() - met < patience) {
    team.run_for(20'000);
    const double since_s = to_seconds(team.now() - met);
    if (!meeting.first_closure_s && team.published(verifier).size() > before)
      meeting.first_closure_s = since_s;
    if (!team.has_bags(verifier, other, met)) meeting.backlog_s = since_s;
  }
  return meeting;
}

Team two_robots(std::uint64_t seed, int keyframes, double ahead_m) {
  return Team(std::make_unique<RadioAir>(2, kFaults, seed, kMegabit),
              {{.keyframes = keyframes}, {.keyframes = keyframes, .from_m = ahead_m}}, {});
}

TEST_CASE("five minutes apart: newest first, the rest behind it, and nothing twice") {
  const int verifier = verifier_of(0, 1);
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Team team = two_robots(seed, 680, 0.0);
    team.run_for(20 * kSecond);
    team.air().cut(0, 1);
    team.run_for(kApart);
    const int sent_apart = team.bags_sent(1 - verifier);
    const Meeting meeting = meet(team, verifier, 40 * kSecond);
    const int sent = team.bags_sent(1 - verifier);
    const int got = team.bags_got(verifier, 1 - verifier);
    std::cout << fmt::format(
        "five minutes apart: first closure after {:.2f} s, backlog after {:.2f} s; {} bags sent, {} before "
        "the "
        "meeting, {} got, {} in vain\n",
        meeting.first_closure_s.value_or(-1.0), meeting.backlog_s, sent, sent_apart, got,
        team.bags_in_vain());
    REQUIRE(meeting.first_closure_s);
    CHECK(*meeting.first_closure_s < 3.0);
    CHECK(got == team.agent(1 - verifier).keyframes(1 - verifier));
    CHECK(team.bags_in_vain() == 0);
    CHECK(sent_apart <
          60);  // 40 came in range, and no more goes into the void than until the silence is noticed
    CHECK(sent < 1.15 * got + 12);
    CHECK(team.bags_sent(verifier) == 0);  // nobody wants them
    CHECK(disagreement(team, 1) == "");
  }
}

TEST_CASE(
    "a first meeting: the first closure within 3 s where views overlap, else within the backlog's time and 3 "
    "s") {
  const int verifier = verifier_of(0, 1);
  double worst_overlapping = 0.0;
  double worst_behind = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const double ahead_m : {0.0, 80.0}) {
      Team team = two_robots(seed, 140, ahead_m);
      team.air().cut(0, 1);
      team.run_for(60 * kSecond + static_cast<Utime>(seed) * 130'000);
      const Meeting meeting = meet(team, verifier, 10 * kSecond);
      INFO("seed " << seed << ", " << ahead_m << " m ahead");
      REQUIRE(meeting.first_closure_s);
      double& worst = ahead_m == 0.0 ? worst_overlapping : worst_behind;
      worst = std::max(worst, *meeting.first_closure_s);
      CHECK(*meeting.first_closure_s < 3.0 + (ahead_m == 0.0 ? 0.0 : meeting.backlog_s));
    }
  }
  std::cout << fmt::format(
      "first meeting: first closure after {:.2f} s at most where views overlap, {:.2f} s where they do not\n",
      worst_overlapping, worst_behind);
}

TEST_CASE("a team in range: what a keyframe's words cost on the air, with all that says that they arrived") {
  for (const double loss : {0.0, 0.1}) {
    auto air = std::make_unique<RadioAir>(3, LinkFaults{.loss = loss, .delay_us = 100'000}, 4, kMegabit);
    RadioAir& radio = *air;
    Team team(std::move(air), std::vector<Drive>(3, {.keyframes = 120}), {});
    team.run_for(70 * kSecond);
    const double keyframes = 3.0 * 120.0;
    const double words = static_cast<double>(radio.count("sent_bytes/place_recognition")) / keyframes;
    const double control = static_cast<double>(radio.count("sent_bytes/control")) / keyframes;
    std::cout << fmt::format(
        "loss {:.0f} %: {:.0f} bytes a keyframe on the air for words, {:.0f} for acknowledgements and signs "
        "of life; "
        "{} of {} bags in vain\n",
        100.0 * loss, words, control, team.bags_in_vain(),
        team.bags_got(0, 1) + team.bags_got(1, 2) + team.bags_got(2, 0));
    CHECK(team.bags_in_vain() == 0);
    CHECK(words < (loss > 0.0 ? 600.0 : 550.0));
  }
}

TEST_CASE("what a bridge forgets with its process is sent again, and no more") {
  auto air = std::make_unique<RadioAir>(3, kFaults, 3, kMegabit);
  RadioAir& radio = *air;
  Team team(std::move(air), std::vector<Drive>(3), {});
  for (const int victim : {0, 1, 2}) {
    team.run_for(4 * kSecond);
    radio.restart_bridge(victim, team.now());
  }
  team.run_until_quiet();
  team.run_for(60 * kSecond);
  CHECK(disagreement(team, 2) == "");
  for (int robot = 0; robot < 3; ++robot) {
    for (int other = 0; other < 3; ++other) {
      if (other != robot && verifier_of(robot, other) == robot)
        CHECK(team.agent(robot).keyframes(other) == kKeyframes);
    }
  }
  CHECK(team.bags_in_vain() == 0);
}

}  // namespace
}  // namespace covey::place
