// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pose_steps.h"

#include <catch2/catch.hpp>
#include <random>

namespace covey::pgo {
namespace {

std::vector<SE3> walk(int n, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<SE3> poses{{}};
  for (int k = 1; k < n; ++k) {
    const Eigen::Vector3d phi(0.3 * normal(random), 0.3 * normal(random), 0.3 * normal(random));
    poses.push_back(poses.back() * SE3{SO3::exp(phi), {1.0, 0.1 * normal(random), 0.0}});
  }
  return poses;
}

double difference(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k)
    largest = std::max(largest, (a[k].inverse() * b[k]).log().norm());
  return largest;
}

TEST_CASE("rounding errors of steps die out") {
  std::mt19937_64 random(1);
  const std::vector<SE3> wanted = walk(50, random);
  std::vector<SE3> held = walk(50, random);
  const std::vector<bool> all(held.size(), true);
  double error = difference(wanted, held);
  for (int update = 0; update < 5; ++update) {
    dpgo_step_t message{};
    encode_steps(held, wanted, all, 64.0, message);
    REQUIRE(add_steps(message, held));
    const double next = difference(wanted, held);
    if (update > 0) REQUIRE(next < 0.2 * error);  // the first may be beyond what one step can say
    error = next;
  }
}

TEST_CASE("a rigid motion of all costs next to nothing but for the first pose") {
  std::mt19937_64 random(2);
  std::vector<SE3> held = walk(100, random);
  const SE3 T{SO3::exp({0.001, 0.002, -0.001}), {0.02, -0.01, 0.03}};
  std::vector<SE3> wanted = held;
  for (SE3& pose : wanted) pose = T * pose;
  dpgo_step_t message{};
  encode_steps(held, wanted, std::vector<bool>(held.size(), true), 16.0, message);
  REQUIRE(message.n < 200);  // 2 bytes a pose
  REQUIRE(add_steps(message, held));
  REQUIRE(difference(wanted, held) < 0.02);
}

TEST_CASE("what does not move costs a bit, and a plane three numbers of six") {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  std::vector<SE3> held(400);
  std::vector<SE3> wanted = held;
  for (SE3& pose : wanted)
    pose = {SO3::exp({0.0, 0.0, normal(random)}), {normal(random), normal(random), 0.0}};
  const auto bytes = [&](const std::vector<bool>& chosen, double resolution) {
    dpgo_step_t message{};
    encode_steps(held, wanted, chosen, resolution, message);
    return message.n;
  };
  REQUIRE(bytes(std::vector<bool>(400, false), 16.0) < 60);
  std::vector<bool> half(400, false);
  std::fill_n(half.begin(), 200, true);
  const std::int32_t all = bytes(std::vector<bool>(400, true), 16.0);
  REQUIRE(all < 1100);  // 3 numbers of about 7 bits
  REQUIRE(bytes(half, 16.0) < all / 2 + 60);
  dpgo_step_t message{};
  encode_steps(held, wanted, half, 16.0, message);
  REQUIRE(add_steps(message, held));
  for (std::size_t k = 200; k < held.size(); ++k) REQUIRE(held[k].translation.norm() == 0.0);
  for (const SE3& pose : held) REQUIRE(pose.translation.z() == 0.0);
}

TEST_CASE("steps of another number of poses, or beyond any measure, are refused and change nothing") {
  std::mt19937_64 random(4);
  const std::vector<SE3> wanted = walk(20, random);
  dpgo_step_t message{};
  encode_steps(std::vector<SE3>(20), wanted, std::vector<bool>(20, true), 16.0, message);
  std::vector<SE3> fewer(19);
  std::vector<SE3> more(40);
  REQUIRE_FALSE(add_steps(message, fewer));
  REQUIRE_FALSE(add_steps(message, more));
  REQUIRE(fewer.back().translation.norm() == 0.0);
  std::vector<SE3> right(20);
  message.translation_unit = 9e3F;
  for (int update = 0; update < 10000 && add_steps(message, right); ++update) {
  }
  REQUIRE(right.back().translation.norm() < 2e8);
  message.code.clear();
  REQUIRE(add_steps(message, fewer));  // no steps
}

}  // namespace
}  // namespace covey::pgo
