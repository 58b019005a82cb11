// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/online.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "core/eval/ate.h"

namespace covey {
namespace {

constexpr Utime kSegment = kUsPerSecond;

SE3 at(double x, double y, double yaw = 0.0) { return {SO3::exp({0.0, 0.0, yaw}), {x, y, 0.0}}; }

Utime stamp(int id) { return kUsPerSecond * (1 + id); }

keyframe_t keyframe(int id, const SE3& T_O_K, Utime segment = kSegment, int robot = 1) {
  keyframe_t message{};
  message.utime = stamp(id);
  message.robot = robot;
  message.segment = segment;
  message.id = id;
  const Eigen::Quaterniond q = T_O_K.rotation.canonical_quaternion();
  const double values[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(values, values + 4, message.q_O_K);
  std::copy(T_O_K.translation.data(), T_O_K.translation.data() + 3, message.t_O_K);
  return message;
}

// Keyframes first, first + 1, ... of the segment.
trajectory_t round_end(int anchor, Utime utime, int first, const std::vector<SE3>& T_W_K, int part = 0,
                       int parts = 1) {
  trajectory_t message{};
  message.utime = utime;
  message.robot = 1;
  message.anchor = anchor;
  message.part = part;
  message.parts = parts;
  for (const SE3& pose : T_W_K) {
    message.segments.push_back(kSegment);
    message.ids.push_back(first++);
    const Eigen::Quaterniond q = pose.rotation.canonical_quaternion();
    const Eigen::Vector3d& t = pose.translation;
    message.T_W_K.insert(message.T_W_K.end(), {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
  }
  message.n = static_cast<std::int32_t>(message.ids.size());
  message.n_values = static_cast<std::int32_t>(message.T_W_K.size());
  return message;
}

void check_near(const SE3& a, const SE3& b) { CHECK((a.inverse() * b).log().norm() < 1e-12); }

TEST_CASE("the last finished round is taken on by odometry, and a later one changes nothing of it") {
  OnlineTrajectory online(1, 0);
  online.take(keyframe(0, at(0, 0)));
  online.take(keyframe(1, at(1, 0)));
  online.take(round_end(0, 10, 0, {at(5, 5, M_PI / 2), at(5, 6.5, M_PI / 2)}));  // W is turned to the left
  online.take(keyframe(2, at(2, 0)));
  online.take(keyframe(3, at(2, 1, M_PI / 2)));
  online.take(round_end(0, 20, 0, {at(0, 0), at(1, 0), at(2, 0), at(3, 0)}));
  online.take(keyframe(4, at(2, 2, M_PI / 2)));
  const Trajectory believed = online.believed();
  CHECK(online.keyframes() == 5);
  REQUIRE(believed.size() == 3);
  CHECK(believed[0].utime == stamp(2));
  check_near(believed[0].pose, at(5, 7.5, M_PI / 2));
  check_near(believed[1].pose, at(4, 7.5, M_PI));
  check_near(believed[2].pose, at(4, 0));
}

TEST_CASE("before the first round in the anchor's frame nothing counts, and other frames are not W") {
  OnlineTrajectory online(1, 0);
  online.take(keyframe(0, at(0, 0)));
  online.take(round_end(1, 10, 0, {at(0, 0)}));
  online.take(keyframe(1, at(1, 0)));
  CHECK(online.believed().empty());
  online.take(round_end(0, 20, 0, {at(7, 0), at(8, 0)}));
  online.take(round_end(1, 30, 0, {at(0, 0), at(1, 0)}));
  online.take(keyframe(2, at(2, 0)));
  REQUIRE(online.believed().size() == 1);
  check_near(online.believed()[0].pose, at(9, 0));
}

TEST_CASE("a round counts when all its parts are there") {
  OnlineTrajectory online(1, 0);
  online.take(keyframe(0, at(0, 0)));
  online.take(round_end(0, 10, 0, {at(7, 0)}, 0, 2));
  online.take(keyframe(1, at(1, 0)));
  CHECK(online.believed().empty());
  online.take(round_end(0, 20, 1, {at(9, 0)}, 1, 2));  // of another round
  online.take(keyframe(2, at(2, 0)));
  CHECK(online.believed().empty());
  online.take(round_end(0, 20, 0, {at(8, 0)}, 0, 2));
  online.take(keyframe(3, at(3, 0)));
  REQUIRE(online.believed().size() == 1);
  check_near(online.believed()[0].pose, at(11, 0));
}

TEST_CASE(
    "a segment that is not placed has no pose in W, repetitions and what is no pose count for nothing") {
  OnlineTrajectory online(1, 0);
  online.take(keyframe(0, at(0, 0)));
  online.take(round_end(0, 10, 0, {at(7, 0)}));
  online.take(keyframe(0, at(0, 0)));
  online.take(keyframe(1, at(1, 0), 2 * kSegment));
  online.take(keyframe(2, at(2, 0), kSegment, 3));
  online.take(keyframe(3, at(std::nan(""), 0)));
  trajectory_t torn = round_end(0, 20, 0, {at(100, 0)});
  torn.T_W_K.pop_back();
  torn.n_values = 6;
  online.take(torn);
  CHECK(online.believed().empty());
  CHECK(online.keyframes() == 2);
  online.take(keyframe(4, at(4, 0)));
  REQUIRE(online.believed().size() == 1);
  check_near(online.believed()[0].pose, at(11, 0));
}

TEST_CASE("where odometry drifts, the error is that of the moment, whatever the last round says") {
  // A robot drives along a square way; odometry is 10 % too long, each round knows the truth of all so far.
  OnlineTrajectory online(1, 0);
  Trajectory truth;
  std::vector<SE3> known;
  for (int id = 0; id < 40; ++id) {
    const double x = id < 20 ? id : 20.0;
    const double y = id < 20 ? 0.0 : id - 20.0;
    online.take(keyframe(id, at(1.1 * x, 1.1 * y)));
    truth.push_back({stamp(id), at(x, y)});
    known.push_back(at(x, y));
    if (id % 10 == 9) online.take(round_end(0, stamp(id), 0, known));
  }
  const TrajectoryError error = trajectory_error({online.believed(), truth});
  CHECK(error.matched == 30);
  CHECK(error.max_m < 1.1);
  CHECK(error.rmse_m > 0.1);
}

}  // namespace
}  // namespace covey
