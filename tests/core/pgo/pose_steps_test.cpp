// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pose_steps.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
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

std::vector<double> chain(int n) {
  std::vector<double> along(n);
  std::iota(along.begin(), along.end(), 0.0);
  return along;
}

std::vector<bool> all(int n) { return std::vector<bool>(n, true); }

double difference(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k)
    largest = std::max(largest, (a[k].inverse() * b[k]).log().norm());
  return largest;
}

TEST_CASE("what rounding leaves out is less than units, and goes with the next steps") {
  std::mt19937_64 random(1);
  const std::vector<SE3> wanted = walk(50, random);
  std::vector<SE3> held = walk(50, random);
  StepCode sender(chain(50));
  StepCode receiver(chain(50));
  for (const double unit : {1.0, 0.1, 0.01, 0.001}) {
    dpgo_advance_t message{};
    sender.encode(held, wanted, all(50), {0.2 * unit, unit}, message);
    REQUIRE(sender.add(message, held, held));
    std::vector<SE3> received = held;
    REQUIRE(receiver.add(message, held, received));
    if (unit < 1.0)
      REQUIRE(difference(wanted, held) < 1.5 * unit);  // the first is beyond what one step can say
  }
  REQUIRE(difference(wanted, held) < 0.0015);
}

TEST_CASE("sender and receivers hold the same poses to the last bit, also those that were not chosen") {
  std::mt19937_64 random(5);
  std::vector<SE3> wanted = walk(40, random);
  std::vector<SE3> sent = wanted;
  std::vector<SE3> received = wanted;
  StepCode sender(chain(40));
  StepCode receiver(chain(40));
  std::normal_distribution<double> normal;
  for (int update = 0; update < 20; ++update) {
    for (SE3& pose : wanted) pose.translation.x() += 0.1 * normal(random);
    std::vector<bool> chosen(40);
    for (int k = 0; k < 40; ++k) chosen[k] = random() % 3 != 0;
    dpgo_advance_t message{};
    sender.encode(sent, wanted, chosen, {1e-3, 1e-2}, message);
    const std::vector<SE3> before = sent;
    REQUIRE(sender.add(message, before, sent));
    REQUIRE(receiver.add(message, before, received));
    for (int k = 0; k < 40; ++k) {
      REQUIRE(sent[k].translation == received[k].translation);
      if (!chosen[k]) REQUIRE(sent[k].translation == before[k].translation);
    }
  }
}

TEST_CASE("a rigid motion of all costs next to nothing but for the first pose") {
  std::mt19937_64 random(2);
  std::vector<SE3> held = walk(100, random);
  const SE3 T{SO3::exp({0.001, 0.002, -0.001}), {0.02, -0.01, 0.03}};
  std::vector<SE3> wanted = held;
  for (SE3& pose : wanted) pose = T * pose;
  StepCode code(chain(100));
  dpgo_advance_t message{};
  code.encode(held, wanted, all(100), {1e-4, 1e-3}, message);
  REQUIRE(message.n < 70);
  REQUIRE(code.add(message, held, held));
  REQUIRE(difference(wanted, held) < 0.003);
}

TEST_CASE("a smooth bend costs less than noise of its size, the more so the longer the code has run") {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  const std::vector<SE3> held = walk(128, random);
  const auto bytes = [&](auto&& step) {
    StepCode code(chain(128));
    std::vector<SE3> sent = held;
    dpgo_advance_t message{};
    for (int update = 0; update < 5; ++update) {
      std::vector<SE3> wanted = sent;
      for (int k = 0; k < 128; ++k) wanted[k].translation += step(k);
      message = {};
      code.encode(sent, wanted, all(128), {1e-3, 0.1}, message);
      REQUIRE(code.add(message, sent, sent));
    }
    return message.n;
  };
  const auto noise =
      bytes([&](int) { return Eigen::Vector3d(normal(random), normal(random), normal(random)); });
  const auto bend = bytes([&](int k) { return Eigen::Vector3d::Constant(1.4 * std::sin(0.04 * k)); });
  REQUIRE(noise < 128 * 3 * 6 / 8);
  REQUIRE(bend < noise / 4);
}

TEST_CASE("what does not move costs next to nothing, and a plane three numbers of six") {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const std::vector<SE3> held(400);
  std::vector<SE3> wanted = held;
  for (SE3& pose : wanted)
    pose = {SO3::exp({0.0, 0.0, normal(random)}), {normal(random), normal(random), 0.0}};
  StepCode code(chain(400));
  const auto bytes = [&](const std::vector<bool>& chosen) {
    dpgo_advance_t message{};
    code.encode(held, wanted, chosen, {0.1, 0.1}, message);
    return message.n;
  };
  REQUIRE(bytes(std::vector<bool>(400, false)) < 10);
  std::vector<bool> half(400, false);
  std::fill_n(half.begin(), 200, true);
  const std::int32_t whole = bytes(all(400));
  REQUIRE(whole < 1000);  // 3 numbers of about 6 bits
  REQUIRE(bytes(half) < whole / 2 + 60);
  dpgo_advance_t message{};
  code.encode(held, wanted, half, {0.1, 0.1}, message);
  std::vector<SE3> moved = held;
  REQUIRE(code.add(message, held, moved));
  for (std::size_t k = 200; k < held.size(); ++k) REQUIRE(moved[k].translation.norm() == 0.0);
  for (const SE3& pose : moved) REQUIRE(pose.translation.z() == 0.0);
}

TEST_CASE("steps of another number of poses, or beyond any measure, are refused and change nothing") {
  std::mt19937_64 random(4);
  const std::vector<SE3> wanted = walk(20, random);
  const std::vector<SE3> start(20);
  dpgo_advance_t message{};
  StepCode(chain(20)).encode(start, wanted, all(20), {0.01, 0.01}, message);
  std::vector<SE3> fewer(19);
  std::vector<SE3> more(40);
  REQUIRE_FALSE(StepCode(chain(19)).add(message, fewer, fewer));
  REQUIRE_FALSE(StepCode(chain(40)).add(message, more, more));
  REQUIRE(fewer.back().translation.norm() == 0.0);
  std::vector<SE3> right(20);
  message.translation_unit = 30;
  REQUIRE_FALSE(StepCode(chain(20)).add(message, right, right));
  REQUIRE(right.back().translation.norm() == 0.0);
  message.code.clear();
  REQUIRE(StepCode(chain(19)).add(message, fewer, fewer));  // no steps
}

}  // namespace
}  // namespace covey::pgo
