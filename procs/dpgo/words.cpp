// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace covey {
namespace {

std::string word_of(const pgo::ApartRobot& robot) {
  switch (robot.why) {
    case pgo::Apart::kSilent:
      return fmt::format("{} {} not heard for {:.0f} s", robot.robot,
                         robot.has_my_frame ? "is away:" : "is apart:", to_seconds(robot.silent_us));
    case pgo::Apart::kNoClosure:
      return fmt::format("{} is apart: no closure with the others", robot.robot);
    case pgo::Apart::kNotYet:
      return fmt::format("{} is new: the next round will have it", robot.robot);
  }
  return "";
}

}  // namespace

std::string round_line(const pgo::RoundResult& result, const pgo::RoundAccount& account) {
  return fmt::format(
      "round {} of robots {}: cost {:.6g}, gradient {:.3g}, weights {} at 0 / {} between / {} at 1, {} "
      "updates in {} "
      "stages, {:.1f} kB, {:.1f} s",
      result.name.number, fmt::join(result.robots, " "), result.owned_cost, result.gradient,
      result.weights_zero, result.weights_between, result.weights_one, result.updates, result.stages,
      static_cast<double>(account.total_bytes()) * 1e-3, to_seconds(account.duration_us));
}

std::string team_line(const std::vector<int>& together, const std::vector<pgo::ApartRobot>& apart) {
  std::string line = together.size() == 1
                         ? fmt::format("robot {} is solved alone", together.front())
                         : fmt::format("robots {} are solved together", fmt::join(together, " "));
  for (const pgo::ApartRobot& robot : apart) line += "; " + word_of(robot);
  return line;
}

}  // namespace covey
