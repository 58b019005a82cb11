// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/ate.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/geometry/alignment.h"

namespace covey {
namespace {

struct Matches {
  std::vector<Eigen::Vector3d> estimate;
  std::vector<Eigen::Vector3d> reference;

  void append(const Matches& other) {
    estimate.insert(estimate.end(), other.estimate.begin(), other.estimate.end());
    reference.insert(reference.end(), other.reference.begin(), other.reference.end());
  }
};

Matches match(const TrajectoryPair& pair, const AteOptions& options) {
  Matches matches;
  for (const auto& [i, j] : match_stamps(pair.estimate, pair.reference, options.max_stamp_difference_s)) {
    matches.estimate.push_back(pair.estimate[i].pose.translation);
    matches.reference.push_back(pair.reference[j].pose.translation);
  }
  return matches;
}

SE3 align(const Matches& matches) {
  return matches.estimate.empty() ? SE3{} : align_points(matches.estimate, matches.reference).T_to_from;
}

TrajectoryError measure(const Matches& matches, const SE3& T_reference_estimate) {
  TrajectoryError error;
  error.matched = static_cast<int>(matches.estimate.size());
  error.T_reference_estimate = T_reference_estimate;
  if (error.matched == 0) return error;
  std::vector<double> distances;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (std::size_t k = 0; k < matches.estimate.size(); ++k) {
    const double distance = (matches.reference[k] - T_reference_estimate * matches.estimate[k]).norm();
    distances.push_back(distance);
    sum += distance;
    sum_of_squares += distance * distance;
  }
  std::sort(distances.begin(), distances.end());
  error.rmse_m = std::sqrt(sum_of_squares / error.matched);
  error.mean_m = sum / error.matched;
  error.median_m = 0.5 * (distances[(distances.size() - 1) / 2] + distances[distances.size() / 2]);
  error.max_m = distances.back();
  return error;
}

TrajectoryError measure(const Matches& matches, const SE3& T_reference_estimate, const TrajectoryPair& pair) {
  TrajectoryError error = measure(matches, T_reference_estimate);
  error.estimate_poses = static_cast<int>(pair.estimate.size());
  error.reference_poses = static_cast<int>(pair.reference.size());
  return error;
}

}  // namespace

std::vector<std::pair<int, int>> match_stamps(const Trajectory& a, const Trajectory& b,
                                              double max_difference_s) {
  const Utime limit = from_seconds(max_difference_s);
  const auto difference = [&](std::size_t i, std::size_t j) { return std::abs(a[i].utime - b[j].utime); };
  std::vector<std::pair<int, int>> pairs;
  std::size_t j = 0;
  for (std::size_t i = 0; i < a.size() && j < b.size(); ++i) {
    while (j + 1 < b.size() && difference(i, j + 1) < difference(i, j)) ++j;
    const bool next_is_nearer = i + 1 < a.size() && difference(i + 1, j) < difference(i, j);
    if (difference(i, j) > limit || next_is_nearer) continue;
    pairs.emplace_back(static_cast<int>(i), static_cast<int>(j));
    ++j;
  }
  return pairs;
}

TrajectoryError trajectory_error(const TrajectoryPair& pair, const AteOptions& options) {
  const Matches matches = match(pair, options);
  return measure(matches, align(matches), pair);
}

TeamError team_error(const std::vector<TrajectoryPair>& robots, const AteOptions& options) {
  std::vector<Matches> matches;
  Matches all;
  for (const TrajectoryPair& pair : robots) {
    matches.push_back(match(pair, options));
    all.append(matches.back());
  }
  const SE3 T_reference_team = align(all);
  TeamError error;
  error.team = measure(all, T_reference_team);
  for (std::size_t r = 0; r < robots.size(); ++r) {
    error.with_team.push_back(measure(matches[r], T_reference_team, robots[r]));
    error.by_itself.push_back(measure(matches[r], align(matches[r]), robots[r]));
    error.team.estimate_poses += error.with_team.back().estimate_poses;
    error.team.reference_poses += error.with_team.back().reference_poses;
  }
  return error;
}

}  // namespace covey
