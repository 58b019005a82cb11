// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/place/score.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <utility>

namespace covey::bench {
namespace {

using place::KeyframeName;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kNearM = 2.0;
constexpr double kNearDeg = 20.0;
constexpr double kEpisodeM = 5.0;

using Ends = std::pair<KeyframeName, KeyframeName>;

Ends ends_of(const loop_t& loop) {
  return {{loop.robot_a, loop.segment_a, loop.id_a}, {loop.robot_b, loop.segment_b, loop.id_b}};
}

double degrees(const SE3& T) { return T.rotation.log().norm() * kDegPerRad; }

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

struct Judged {
  std::set<Ends> right;
  std::vector<std::string> wrong;
  std::vector<double> metres;  // of the true ones
  std::vector<double> degrees;
  std::vector<double> nees;
  std::map<std::pair<int, int>, std::pair<int, int>> pairs;  // accepted, true
};

// Both ends have each closure: it counts once.
Judged judge(const Views& views, const std::vector<loop_t>& loops, const Limits& limits) {
  Judged judged;
  std::set<Ends> seen;
  for (const loop_t& loop : loops) {
    const Ends ends = ends_of(loop);
    if (!seen.insert(ends).second) continue;
    const SE3 truth = views.at(ends.first).T_W_B.inverse() * views.at(ends.second).T_W_B;
    const SE3 T_A_B{SO3::from_quaternion({loop.q_A_B[0], loop.q_A_B[1], loop.q_A_B[2], loop.q_A_B[3]}),
                    {loop.t_A_B[0], loop.t_A_B[1], loop.t_A_B[2]}};
    const Vector6d error = (T_A_B.inverse() * truth).log();
    const double off_m = error.head<3>().norm();
    const double off_deg = error.tail<3>().norm() * kDegPerRad;
    auto& [accepted, right] = judged.pairs[{loop.robot_a, loop.robot_b}];
    ++accepted;
    if (off_m > limits.translation_m || off_deg > limits.rotation_deg) {
      judged.wrong.push_back(
          fmt::format("{}/{} {}/{}: {:.2f} m {:.1f} deg off, truly {:.1f} m and {:.0f} deg apart, {} of {} "
                      "matches, similarity {:.2f}",
                      loop.robot_a, loop.id_a, loop.robot_b, loop.id_b, off_m, off_deg,
                      truth.translation.norm(), degrees(truth), loop.inliers, loop.matches, loop.similarity));
      continue;
    }
    ++right;
    judged.right.insert(ends);
    judged.metres.push_back(off_m);
    judged.degrees.push_back(off_deg);
    const Eigen::Map<const Matrix6d> covariance(loop.covariance);
    judged.nees.push_back(error.dot(covariance.ldlt().solve(error)));
  }
  return judged;
}

std::map<int, std::vector<View>> by_robot(const Views& views) {
  std::map<int, std::vector<View>> ways;
  for (const auto& [name, view] : views) ways[name.robot].push_back(view);
  return ways;
}

bool is_near(const View& view, const std::vector<View>& way) {
  return std::any_of(way.begin(), way.end(), [&view](const View& other) { return are_near(view, other); });
}

bool is_found(const std::vector<KeyframeName>& episode, int other, const std::set<Ends>& right) {
  return std::any_of(right.begin(), right.end(), [&](const Ends& ends) {
    const auto joins = [&](const KeyframeName& here, const KeyframeName& there) {
      return there.robot == other && std::find(episode.begin(), episode.end(), here) != episode.end();
    };
    return joins(ends.first, ends.second) || joins(ends.second, ends.first);
  });
}

// Of one way towards another robot's.
std::vector<std::vector<KeyframeName>> episodes_of(const std::vector<View>& way,
                                                   const std::vector<View>& others) {
  std::vector<std::vector<KeyframeName>> episodes;
  double metres = 0.0;
  bool open = false;
  for (std::size_t k = 0; k < way.size(); ++k) {
    if (k > 0) metres += (way[k].T_W_B.translation - way[k - 1].T_W_B.translation).norm();
    const bool near = is_near(way[k], others);
    if (near && (!open || metres >= kEpisodeM)) {
      episodes.emplace_back();
      metres = 0.0;
    }
    open = near;
    if (near) episodes.back().push_back(way[k].name);
  }
  return episodes;
}

double metres_of(const std::vector<View>& way) {
  double metres = 0.0;
  for (std::size_t k = 1; k < way.size(); ++k)
    metres += (way[k].T_W_B.translation - way[k - 1].T_W_B.translation).norm();
  return metres;
}

}  // namespace

bool are_near(const View& a, const View& b) {
  const SE3 apart = a.T_W_B.inverse() * b.T_W_B;
  return apart.translation.norm() < kNearM && degrees(apart) < kNearDeg;
}

nlohmann::json score(const Views& views, const std::vector<loop_t>& loops, const Limits& limits) {
  const Judged judged = judge(views, loops, limits);
  const auto ways = by_robot(views);
  int episodes = 0;
  int found = 0;
  double metres = 0.0;
  for (const auto& [robot, way] : ways) {
    metres += metres_of(way);
    for (const auto& [other, others] : ways) {
      if (other == robot) continue;
      for (const auto& episode : episodes_of(way, others)) {
        ++episodes;
        found += is_found(episode, other, judged.right) ? 1 : 0;
      }
    }
  }
  nlohmann::json result;
  const double n = std::max<double>(1.0, static_cast<double>(judged.nees.size()));
  result["accepted"] = judged.right.size() + judged.wrong.size();
  result["true"] = judged.right.size();
  result["wrong"] = judged.wrong;
  result["median_m"] = median(judged.metres);
  result["median_deg"] = median(judged.degrees);
  result["worst_m"] = largest(judged.metres);
  result["worst_deg"] = largest(judged.degrees);
  result["nees"] = std::accumulate(judged.nees.begin(), judged.nees.end(), 0.0) / n;
  result["nees_median"] = median(judged.nees);
  result["episodes"] = episodes;
  result["episodes_found"] = found;
  result["recall"] = episodes > 0 ? static_cast<double>(found) / episodes : 0.0;
  result["metres"] = metres;
  for (const auto& [pair, counts] : judged.pairs) {
    result["pairs"].push_back(
        {{"a", pair.first}, {"b", pair.second}, {"accepted", counts.first}, {"true", counts.second}});
  }
  return result;
}

}  // namespace covey::bench
