// SPDX-License-Identifier: BSD-3-Clause
#include "core/imu/imu_factor.h"

#include <catch2/catch.hpp>

#include "core/graph/pose_factors.h"
#include "core/graph/solve.h"
#include "core/imu/propagate.h"
#include "tests/core/graph/factor_testing.h"
#include "tests/core/imu/motion.h"

using namespace covey;
using namespace covey::graph;
using covey::testing::add_imu_errors;
using covey::testing::AnalyticMotion;
using covey::testing::RandomGeometry;
using covey::testing::sample_imu;
using graph::testing::jacobian_error;

TEST_CASE("ImuFactor: analytic Jacobians are the numeric ones, near the solution and far from it") {
  RandomGeometry random;
  const AnalyticMotion motion;
  const Preintegration increment({}, {{0.01, 0.02, 0.03}, {0.1, 0.2, 0.3}},
                                 sample_imu(motion, 0, 250'000, 5000));
  for (int trial = 0; trial < 50; ++trial) {
    const double far = trial < 25 ? 0.01 : 0.5;
    Values values;
    const NavState i{random.pose(), random.vector<3>(), {random.vector<3>(0.02), random.vector<3>(0.2)}};
    const NavState j = increment.predict(i);
    values.set({'x', 0}, i.T_W_B);
    values.set({'v', 0}, Vector<3>(i.v_W));
    values.set({'b', 0}, i.bias.vector());
    values.set({'x', 1}, j.T_W_B * SE3::exp(random.vector<6>(far)));
    values.set({'v', 1}, Vector<3>(j.v_W + random.vector<3>(far)));
    REQUIRE(jacobian_error(ImuFactor{increment}, {{'x', 0}, {'v', 0}, {'b', 0}, {'x', 1}, {'v', 1}}, values) <
            1e-6);
  }
}

TEST_CASE("ImuFactor: zero at what the samples predict, for any start and any bias near the integrated one") {
  RandomGeometry random;
  const Preintegration increment({}, {}, sample_imu(AnalyticMotion{}, 0, 250'000, 5000));
  const NavState i{random.pose(), random.vector<3>(), {random.vector<3>(0.01), random.vector<3>(0.1)}};
  const NavState j = increment.predict(i);
  const Vector9d r = ImuFactor{increment}.evaluate(i.T_W_B, i.v_W, i.bias.vector(), j.T_W_B, j.v_W, nullptr,
                                                   nullptr, nullptr, nullptr, nullptr);
  REQUIRE(r.norm() < 1e-12);
}

TEST_CASE("BiasWalk: analytic Jacobians are the numeric ones, noise grows with the root of time") {
  RandomGeometry random;
  Values values;
  values.set({'b', 0}, random.vector<6>());
  values.set({'b', 1}, random.vector<6>());
  REQUIRE(jacobian_error(BiasWalk{}, {{'b', 0}, {'b', 1}}, values) < 1e-8);
  const ImuNoise imu;
  REQUIRE(bias_walk_noise(imu, 4.0).sqrt_information()(0, 0) == Approx(1.0 / (2.0 * imu.gyro_walk)));
  REQUIRE(bias_walk_noise(imu, 4.0).sqrt_information()(5, 5) == Approx(1.0 / (2.0 * imu.accel_walk)));
}

TEST_CASE("ImuFactor: with poses given now and then, a graph finds velocities and biases") {
  RandomGeometry random(2);
  const AnalyticMotion motion;
  const ImuNoise noise;
  const ImuBias bias{{0.05, -0.03, 0.08}, {0.2, -0.1, 0.15}};
  constexpr int kStates = 40;
  constexpr Utime kStep = 250'000;
  auto samples = sample_imu(motion, 0, kStates * kStep, 5000);
  add_imu_errors(noise, bias, random, samples);
  Graph graph;
  Values values;
  for (std::uint64_t k = 0; k < kStates; ++k) {
    const NavState truth = motion.state(static_cast<Utime>(k) * kStep);
    const SE3 measured = truth.T_W_B * SE3::exp(random.vector<6>(2e-3));
    graph.add(Prior<SE3>{measured}, {{'x', k}}, Noise<6>::sigma(2e-3));
    values.set({'x', k}, measured);
    values.set({'v', k}, Vector<3>(Vector<3>::Zero()));
    values.set({'b', k}, Vector<6>(Vector<6>::Zero()));
    if (k == 0) continue;
    const std::span<const ImuSample> between(samples.data() + (k - 1) * 50, 51);
    const Preintegration increment(noise, {}, between);
    graph.add(ImuFactor{increment}, {{'x', k - 1}, {'v', k - 1}, {'b', k - 1}, {'x', k}, {'v', k}},
              imu_noise(increment));
    graph.add(BiasWalk{}, {{'b', k - 1}, {'b', k}}, bias_walk_noise(noise, increment.duration_s()));
  }
  REQUIRE(solve(graph, values).converged);
  const std::uint64_t last = kStates - 1;
  const Vector6d found = values.get<Vector<6>>({'b', last});
  REQUIRE((found.head<3>() - bias.gyro).norm() < 2e-3);
  REQUIRE((found.tail<3>() - bias.accel).norm() < 3e-2);
  for (std::uint64_t k = 0; k < kStates; ++k) {
    const NavState truth = motion.state(static_cast<Utime>(k) * kStep);
    REQUIRE((values.get<Vector<3>>({'v', k}) - truth.v_W).norm() < 2e-2);
    REQUIRE((values.get<SE3>({'x', k}).translation - truth.T_W_B.translation).norm() < 5e-3);
  }
}
