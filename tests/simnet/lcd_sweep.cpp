// SPDX-License-Identifier: BSD-3-Clause
#include "tests/simnet/lcd_sweep.h"

#include <fmt/format.h>

#include <limits>

#include "tests/simnet/lcd_team.h"
#include "tests/simnet/seeds.h"

namespace covey::place {
namespace {

constexpr Utime kEnd = 900 * kSecond;

LcdOptions quick() {
  LcdOptions options;
  options.asking.again_us = 2 * kSecond;
  options.repeat_loop_us = 2 * kSecond;
  options.verifications_per_s = 20.0;
  return options;
}

std::string lacking_bags(Team& team) {
  for (int a = 0; a < team.robots(); ++a) {
    for (int b = 0; b < team.robots(); ++b) {
      if (a == b || verifier_of(a, b) != a) continue;
      const int has = team.agent(a).keyframes(b);
      const int all = team.agent(b).keyframes(b);
      if (has < all) return fmt::format("{} has {} of {} bags of {}", a, has, all, b);
    }
  }
  return "";
}

bool all_told(Team& team) {
  for (int robot = 0; robot < team.robots(); ++robot) {
    if (team.agent(robot).untold() > 0) return false;
  }
  return true;
}

class Sweep {
 public:
  explicit Sweep(std::uint64_t seed) : random_(seed) {
    const int robots = 2 + random_.below(3);
    const LinkFaults faults{.loss = random_.uniform(0.0, 0.4),
                            .delay_us = static_cast<Utime>(random_.uniform(0.0, 5e5)),
                            .jitter_us = static_cast<Utime>(random_.uniform(0.0, 5e5)),
                            .duplicate = random_.uniform(0.0, 0.3)};
    std::unique_ptr<Air> air;
    run_.radio = random_.chance(0.5);
    double rate = 0.0;
    if (run_.radio) {
      rate = random_.chance(0.5) ? 125'000.0 : 20'000.0;
      auto radio = std::make_unique<RadioAir>(robots, faults, seed, rate);
      radio_ = radio.get();
      air = std::move(radio);
    } else {
      air = std::make_unique<BareAir>(robots, faults, seed);
    }
    std::vector<Drive> drives;
    for (int robot = 0; robot < robots; ++robot) {
      drives.push_back({.keyframes = 20 + random_.below(15)});
      if (random_.chance(0.3)) drives.back().new_segment_at = 5 + random_.below(12);
    }
    team_ = std::make_unique<Team>(std::move(air), drives, quick());
    run_.story =
        fmt::format("{} robots, loss {:.2f}, delay {:.2f} + {:.2f} s, doubles {:.2f}, {}", robots,
                    faults.loss, to_seconds(faults.delay_us), to_seconds(faults.jitter_us), faults.duplicate,
                    run_.radio ? fmt::format("radio {:.0f} kB/s", rate / 1e3) : "bare");
  }

  LcdSweepRun run() {
    for (int events = random_.below(6); events > 0; --events) {
      team_->run_for(static_cast<Utime>(random_.uniform(0.5, 6.0) * 1e6));
      happen();
    }
    team_->air().heal();
    while (team_->now() < kEnd) {
      team_->run_for(5 * kSecond);
      if (team_->is_quiet() && all_told(*team_) && lacking_bags(*team_).empty()) break;
    }
    judge();
    return run_;
  }

 private:
  int anyone() { return random_.below(team_->robots()); }

  void happen() {
    const int robot = anyone();
    switch (random_.below(5)) {
      case 0:
        tell(fmt::format("cut {} from the next", robot));
        team_->air().cut(robot, (robot + 1) % team_->robots());
        return;
      case 1: {
        const double apart_s = random_.chance(0.3) ? 80.0 : random_.uniform(2.0, 20.0);
        tell(fmt::format("{} away for {:.0f} s", robot, apart_s));
        team_->air().isolate(robot);
        team_->run_for(static_cast<Utime>(apart_s * 1e6));
        team_->air().heal();
        return;
      }
      case 2:
        if (radio_ == nullptr) return;
        tell(fmt::format("bridge of {} anew", robot));
        radio_->restart_bridge(robot, team_->now());
        return;
      case 3:
        if (team_->agent(robot).untold() > 0) return;
        tell(fmt::format("{} killed, without its memory", robot));
        return team_->restart(robot, false);
      default:
        tell(fmt::format("{} killed", robot));
        return team_->restart(robot, true);
    }
  }

  void tell(const std::string& what) {
    run_.story += fmt::format("; {:.1f} s: {}", to_seconds(team_->now()), what);
  }

  void judge() {
    run_.failure = disagreement(*team_, 0);
    if (run_.failure.empty()) run_.failure = lacking_bags(*team_);
    if (run_.failure.empty() && !has_good_streams(*team_)) run_.failure = "a stream has gaps";
    if (run_.failure.empty() && team_->now() >= kEnd) run_.failure = "it does not come to rest";
    for (int a = 0; a < team_->robots(); ++a) {
      for (int b = 0; b < team_->robots(); ++b) {
        if (a < b) run_.closures += static_cast<int>(team_->closures(a, b).size());
        run_.bags_got += team_->bags_got(a, b);
      }
    }
    run_.bags_in_vain = team_->bags_in_vain();
    run_.seconds = to_seconds(team_->now());
  }

  SeededRandom random_;
  RadioAir* radio_ = nullptr;
  std::unique_ptr<Team> team_;
  LcdSweepRun run_;
};

}  // namespace

LcdSweepRun run_lcd_seed(std::uint64_t seed) { return Sweep(seed).run(); }

}  // namespace covey::place
