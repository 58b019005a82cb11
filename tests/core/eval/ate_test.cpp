// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/ate.h"

#include <catch2/catch.hpp>
#include <random>

namespace covey {
namespace {

constexpr Utime kStep = 100'000;

SE3 some_motion() {
  Vector6d xi;
  xi << 3.0, -20.0, 1.0, 0.4, -0.8, 2.0;
  return SE3::exp(xi);
}

Trajectory helix(int n, double offset_m = 0.0) {
  Trajectory trajectory;
  for (int k = 0; k < n; ++k) {
    const double a = 0.1 * k;
    trajectory.push_back({kStep * k, {SO3{}, {5.0 * std::cos(a) + offset_m, 5.0 * std::sin(a), 0.05 * k}}});
  }
  return trajectory;
}

Trajectory moved(Trajectory trajectory, const SE3& T) {
  for (auto& [utime, pose] : trajectory) pose = T * pose;
  return trajectory;
}

TEST_CASE("a moved copy has no error, and the motion is found") {
  const TrajectoryError error = trajectory_error({moved(helix(60), some_motion().inverse()), helix(60)});
  CHECK(error.matched == 60);
  CHECK(error.rmse_m < 1e-9);
  CHECK((error.T_reference_estimate.inverse() * some_motion()).log().norm() < 1e-9);
}

TEST_CASE("the figures are those of the distances") {
  // Up and down by d in turn: whatever d, the alignment is the identity and every distance is d.
  Trajectory estimate = helix(200);
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    estimate[k].pose.translation.z() += (k / 2 + k) % 2 == 0 ? 0.1 : -0.1;
  }
  const TrajectoryError error = trajectory_error({estimate, helix(200)});
  CHECK(error.rmse_m == Approx(0.1).epsilon(0.01));
  CHECK(error.mean_m == Approx(0.1).epsilon(0.01));
  CHECK(error.median_m == Approx(0.1).epsilon(0.01));
  CHECK(error.max_m == Approx(0.1).epsilon(0.05));
  CHECK(error.mean_m <= error.rmse_m);
}

TEST_CASE("poses are matched by stamp, once, within the limit") {
  Trajectory a = helix(3);
  Trajectory b = helix(3);
  b[0].utime += 4'000;
  b[2].utime += 30'000;
  using Pairs = std::vector<std::pair<int, int>>;
  CHECK(match_stamps(a, b, 0.01) == Pairs{{0, 0}, {1, 1}});
  CHECK(match_stamps(a, b, 0.05) == Pairs{{0, 0}, {1, 1}, {2, 2}});
  CHECK(match_stamps(a, {}, 0.01).empty());
  // Of two poses that want the same one, the nearer gets it.
  const Trajectory dense = {{0, {}}, {6'000, {}}};
  const Trajectory single = {{5'000, {}}};
  CHECK(match_stamps(dense, single, 0.01) == Pairs{{1, 0}});
  CHECK(match_stamps(single, dense, 0.01) == Pairs{{0, 1}});
}

TEST_CASE("without common stamps nothing is matched") {
  Trajectory late = helix(5);
  for (auto& pose : late) pose.utime += 100 * kUsPerSecond;
  const TrajectoryError error = trajectory_error({late, helix(5)});
  CHECK(error.matched == 0);
  CHECK(error.estimate_poses == 5);
  CHECK(error.reference_poses == 5);
}

TEST_CASE("a team has one alignment: a robot that is wrongly placed counts") {
  const TrajectoryPair good{moved(helix(50), some_motion()), helix(50)};
  const TrajectoryPair displaced{moved(helix(50, 22.0), some_motion()), helix(50, 20.0)};
  const TeamError error = team_error({good, displaced});
  CHECK(error.team.matched == 100);
  CHECK(error.team.estimate_poses == 100);
  CHECK(error.team.rmse_m > 0.5);
  REQUIRE(error.by_itself.size() == 2);
  CHECK(error.by_itself[0].rmse_m < 1e-9);
  CHECK(error.by_itself[1].rmse_m < 1e-9);
  const double both = std::pow(error.with_team[0].rmse_m, 2) + std::pow(error.with_team[1].rmse_m, 2);
  CHECK(std::sqrt(both / 2) == Approx(error.team.rmse_m));
}

}  // namespace
}  // namespace covey
