// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/drive.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/imu/propagate.h"
#include "core/sim/imu.h"

namespace covey::sim {
namespace {

constexpr Utime kBegin = 1'600'000'000'000'000;

// Twice round a block: right turns, then a left one.
std::vector<Eigen::Vector3d> block() {
  return {{0, 0, 0}, {12, 0, 0}, {12, -12, 0}, {0, -12, 0}, {0, 0, 0}, {12, 0, 0}, {12, 12, 0}, {40, 12, 0}};
}

Motion drive_block(double seconds = 45.0) { return drive(block(), {}, kBegin, seconds, 7); }

TEST_CASE("velocity, acceleration and turn rate are the derivatives of the pose") {
  const Motion motion = drive_block();
  CHECK(motion.end - motion.begin == 45'000'000);
  const Utime h = 200;
  const double span = to_seconds(2 * h);
  for (Utime t = motion.begin + h; t + h <= motion.end; t += 33'333) {
    const MotionState a = motion.at(t - h);
    const MotionState state = motion.at(t);
    const MotionState b = motion.at(t + h);
    CHECK(((b.T_W_B.translation - a.T_W_B.translation) / span - state.v_W).norm() < 1e-4);
    CHECK(((b.v_W - a.v_W) / span - state.a_W).norm() < 5e-3);
    CHECK(((a.T_W_B.rotation.inverse() * b.T_W_B.rotation).log() / span - state.omega_B).norm() < 1e-4);
  }
}

TEST_CASE(
    "a drive stands still, speeds up, looks where it goes and turns no faster than a camera can follow") {
  const DriveOptions options;
  const Motion motion = drive_block();
  const Eigen::Vector3d p_start = motion.at(kBegin).T_W_B.translation;
  CHECK((p_start - Eigen::Vector3d(0, 0, options.body_height_m)).norm() < 1e-9);
  CHECK(motion.at(kBegin + 1'000'000).T_W_B.translation == p_start);
  CHECK(motion.at(kBegin + 1'000'000).omega_B.norm() == 0.0);
  double fastest_turn = 0.0;
  for (Utime t = kBegin + 5'000'000; t <= motion.end; t += 10'000) {
    const MotionState state = motion.at(t);
    const Eigen::Vector3d v_B = state.T_W_B.rotation.inverse() * state.v_W;
    CHECK(v_B.x() > 0.65 * options.speed);  // slower round the corners
    CHECK(std::abs(v_B.y()) < 0.2);
    CHECK(std::abs(state.T_W_B.translation.z() - options.body_height_m) < 0.01);
    fastest_turn = std::max(fastest_turn, state.omega_B.norm());
  }
  CHECK(fastest_turn > 0.4);
  CHECK(fastest_turn < 1.0);
}

TEST_CASE("the same seed gives the same drive, another one another suspension") {
  const Utime t = kBegin + 20'000'000;
  CHECK(drive_block().at(t).T_W_B.translation == drive_block().at(t).T_W_B.translation);
  const Motion other = drive(block(), {}, kBegin, 45.0, 8);
  const double apart = (other.at(t).T_W_B.translation - drive_block().at(t).T_W_B.translation).norm();
  CHECK(apart > 0.0);
  CHECK(apart < 0.01);
}

NavState state_at(const Motion& motion, Utime utime) {
  const MotionState state = motion.at(utime);
  return {.T_W_B = state.T_W_B, .v_W = state.v_W, .bias = {}};
}

TEST_CASE("an IMU without noise integrates back to the motion") {
  const Motion motion = drive_block(20.0);
  const ImuOptions options{
      .noise = {.rate_hz = 200.0, .gyro_noise = 0, .gyro_walk = 0, .accel_noise = 0, .accel_walk = 0},
      .gyro_bias_sigma = 0.0,
      .accel_bias_sigma = 0.0};
  const ImuRecord record = simulate_imu(motion, options, 1);
  REQUIRE(record.samples.size() == 4001);
  const NavState end = propagate(state_at(motion, motion.begin), options.noise, record.samples);
  const MotionState truth = motion.at(motion.end);
  CHECK((end.T_W_B.translation - truth.T_W_B.translation).norm() < 0.01);
  CHECK((end.T_W_B.rotation.inverse() * truth.T_W_B.rotation).log().norm() < 2e-4);
}

TEST_CASE("the IMU's noise and bias walk have the densities asked for, and its record repeats") {
  const Motion motion = drive_block();
  const ImuOptions options;
  const ImuRecord record = simulate_imu(motion, options, 5);
  const ImuRecord again = simulate_imu(motion, options, 5);
  const ImuRecord other = simulate_imu(motion, options, 6);
  CHECK(record.samples[77].gyro == again.samples[77].gyro);
  CHECK(record.samples[77].gyro != other.samples[77].gyro);
  CHECK(record.biases.front().gyro.norm() > 0.0);
  CHECK(record.biases.front().accel.norm() > 0.0);

  double gyro = 0.0;
  double accel = 0.0;
  double gyro_walk = 0.0;
  double accel_walk = 0.0;
  const std::size_t n = record.samples.size();
  for (std::size_t k = 0; k < n; ++k) {
    const ImuSample& sample = record.samples[k];
    const MotionState state = motion.at(sample.utime);
    const Eigen::Vector3d force = state.T_W_B.rotation.inverse() * Eigen::Vector3d(state.a_W - kGravity);
    gyro += (sample.gyro - state.omega_B - record.biases[k].gyro).squaredNorm() / 3.0;
    accel += (sample.accel - force - record.biases[k].accel).squaredNorm() / 3.0;
    if (k == 0) continue;
    gyro_walk += (record.biases[k].gyro - record.biases[k - 1].gyro).squaredNorm() / 3.0;
    accel_walk += (record.biases[k].accel - record.biases[k - 1].accel).squaredNorm() / 3.0;
  }
  const double count = static_cast<double>(n);
  CHECK(std::sqrt(gyro / count / 200.0) == Approx(options.noise.gyro_noise).epsilon(0.03));
  CHECK(std::sqrt(accel / count / 200.0) == Approx(options.noise.accel_noise).epsilon(0.03));
  CHECK(std::sqrt(gyro_walk / count * 200.0) == Approx(options.noise.gyro_walk).epsilon(0.03));
  CHECK(std::sqrt(accel_walk / count * 200.0) == Approx(options.noise.accel_walk).epsilon(0.03));
}

}  // namespace
}  // namespace covey::sim
