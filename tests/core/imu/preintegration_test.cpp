// SPDX-License-Identifier: BSD-3-Clause
#include "core/imu/preintegration.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "core/imu/imu_buffer.h"
#include "core/imu/propagate.h"
#include "tests/core/imu/motion.h"

using namespace covey;
using covey::testing::add_imu_errors;
using covey::testing::AnalyticMotion;
using covey::testing::RandomGeometry;
using covey::testing::sample_imu;

namespace {

// [rho; phi; v] as in the header: how `measured` must be disturbed to become `truth`.
Vector9d increment_error(const ImuIncrement& measured, const ImuIncrement& truth) {
  Vector9d e;
  e << truth.dp - measured.dp, (measured.dR.inverse() * truth.dR).log(), truth.dv - measured.dv;
  return e;
}

}  // namespace

TEST_CASE("Preintegration: a second of IMU carries an analytic motion's state to its end") {
  const AnalyticMotion motion;
  const NavState start = motion.state(2 * kUsPerSecond);
  const NavState truth = motion.state(3 * kUsPerSecond);
  const auto coarse = sample_imu(motion, 2 * kUsPerSecond, 3 * kUsPerSecond, 5000);
  const NavState end = propagate(start, {}, coarse);
  REQUIRE((end.T_W_B.translation - truth.T_W_B.translation).norm() < 5e-5);
  REQUIRE((end.v_W - truth.v_W).norm() < 1e-4);
  REQUIRE((end.T_W_B.rotation.inverse() * truth.T_W_B.rotation).log().norm() < 1e-5);

  // The rule is of second order: a tenth of the step, a hundredth of the error.
  const NavState fine = propagate(start, {}, sample_imu(motion, 2 * kUsPerSecond, 3 * kUsPerSecond, 500));
  REQUIRE((fine.T_W_B.translation - truth.T_W_B.translation).norm() <
          0.02 * (end.T_W_B.translation - truth.T_W_B.translation).norm());
  REQUIRE((fine.v_W - truth.v_W).norm() < 0.02 * (end.v_W - truth.v_W).norm());
}

TEST_CASE("Preintegration: in pieces or at once gives the same state") {
  const AnalyticMotion motion;
  const auto all = sample_imu(motion, 0, kUsPerSecond, 5000);
  const std::span<const ImuSample> samples(all);
  const NavState start = motion.state(0);
  const NavState once = propagate(start, {}, samples);
  const NavState twice = propagate(propagate(start, {}, samples.first(81)), {}, samples.subspan(80));
  REQUIRE((once.T_W_B.matrix() - twice.T_W_B.matrix()).norm() < 1e-12);
  REQUIRE((once.v_W - twice.v_W).norm() < 1e-12);
}

TEST_CASE("Preintegration: doubled and backward samples change nothing") {
  Preintegration increment({}, {});
  const ImuSample sample{1000, {1, 2, 3}, {4, 5, 6}};
  increment.add(sample, sample);
  increment.add(sample, {500, {1, 2, 3}, {4, 5, 6}});
  REQUIRE(increment.duration_s() == 0.0);
  REQUIRE(increment.increment().dv.norm() == 0.0);
}

TEST_CASE("Preintegration: the bias Jacobian predicts what another bias gives") {
  RandomGeometry random;
  const AnalyticMotion motion;
  const auto samples = sample_imu(motion, 0, kUsPerSecond / 2, 5000);
  const ImuBias bias{{0.02, -0.05, 0.08}, {0.1, -0.2, 0.3}};
  const Preintegration increment({}, bias, samples);
  constexpr double kStep = 1e-6;
  for (int c = 0; c < 6; ++c) {
    const Vector6d d = kStep * Vector6d::Unit(c);
    const Preintegration ahead({}, ImuBias::from_vector(bias.vector() + d), samples);
    const Preintegration behind({}, ImuBias::from_vector(bias.vector() - d), samples);
    const Vector9d slope = increment_error(behind.increment(), ahead.increment()) / (2.0 * kStep);
    REQUIRE((slope - increment.bias_jacobian().col(c)).norm() < 1e-6);
  }
  // A step of a realistic size: the first order is within a hundredth of the change.
  const ImuBias other{bias.gyro + Eigen::Vector3d(0.005, 0.005, -0.005),
                      bias.accel + Eigen::Vector3d(0.05, 0.05, 0.05)};
  const Preintegration again({}, other, samples);
  const double change = increment_error(increment.increment(), again.increment()).norm();
  REQUIRE(increment_error(increment.corrected(other), again.increment()).norm() < 0.01 * change);
}

TEST_CASE("Preintegration: the covariance is that of a Monte Carlo experiment") {
  RandomGeometry random(3);
  const AnalyticMotion motion;
  ImuNoise noise;
  noise.gyro_noise *= 10.0;
  noise.gyro_walk = noise.accel_walk = 1e-12;
  const auto clean = sample_imu(motion, 0, 300'000, 5000);
  const Preintegration truth(noise, {}, clean);
  constexpr int kTrials = 4000;
  Matrix9d sum = Matrix9d::Zero();
  for (int trial = 0; trial < kTrials; ++trial) {
    auto noisy = clean;
    add_imu_errors(noise, {}, random, noisy);
    const Vector9d e = increment_error(Preintegration(noise, {}, noisy).increment(), truth.increment());
    sum += e * e.transpose();
  }
  // In units of the predicted standard deviations, including correlations: white.
  const Eigen::LLT<Matrix9d> root(truth.covariance());
  const Matrix9d white = root.matrixL().solve(Matrix9d(root.matrixL().solve(sum / kTrials).transpose()));
  const Eigen::SelfAdjointEigenSolver<Matrix9d> eigen(0.5 * (white + white.transpose()));
  CAPTURE(eigen.eigenvalues().transpose());
  REQUIRE(eigen.eigenvalues()(1) > 0.8);
  REQUIRE(eigen.eigenvalues().maxCoeff() < 1.2);
}

TEST_CASE("Propagate: errors of the start and of the IMU grow as a Monte Carlo experiment says") {
  RandomGeometry random(4);
  const AnalyticMotion motion;
  const ImuNoise noise;
  NavState start = motion.state(0);
  start.bias = {{0.01, 0.02, -0.03}, {0.1, 0.0, -0.1}};
  Vector6d pose_sigmas;
  pose_sigmas << 0.02, 0.02, 0.02, 0.01, 0.01, 0.01;
  Matrix15d covariance = Matrix15d::Zero();
  covariance.diagonal() << pose_sigmas.cwiseAbs2(), Eigen::Vector3d::Constant(0.05 * 0.05),
      Eigen::Vector3d::Constant(1e-6), Eigen::Vector3d::Constant(1e-3);
  const auto clean = sample_imu(motion, 0, 500'000, 5000);
  auto biased = clean;
  for (ImuSample& sample : biased) {
    sample.gyro += start.bias.gyro;
    sample.accel += start.bias.accel;
  }
  const Preintegration increment(noise, start.bias, biased);
  const NavState mean = increment.predict(start);
  const Matrix15d predicted = propagate_covariance(start, covariance, increment);
  constexpr int kTrials = 2000;
  double nees = 0.0;
  const Eigen::LLT<Matrix9d> root(Matrix9d(predicted.topLeftCorner<9, 9>()));
  for (int trial = 0; trial < kTrials; ++trial) {
    NavState other = start;
    other.T_W_B = start.T_W_B * SE3::exp(pose_sigmas.cwiseProduct(random.vector<6>()));
    other.v_W += random.vector<3>(0.05);
    other.bias.gyro += random.vector<3>(1e-3);
    other.bias.accel += random.vector<3>(std::sqrt(1e-3));
    auto samples = biased;
    add_imu_errors(noise, {}, random, samples);
    const NavState end = propagate(other, noise, samples);
    Vector9d e;
    e << (mean.T_W_B.inverse() * end.T_W_B).log(), end.v_W - mean.v_W;
    nees += root.matrixL().solve(e).squaredNorm();
  }
  REQUIRE(nees / kTrials == Approx(9.0).margin(0.6));
  REQUIRE(predicted.diagonal().tail<3>().minCoeff() > 1e-3);
}

TEST_CASE("Preintegration: made-up samples count for little, and those interpolated from them are made up") {
  const AnalyticMotion motion;
  const ImuNoise noise;
  double told = 0.0;
  constexpr int kRuns = 20;
  for (int k = 0; k < kRuns; ++k) {
    const Utime begin = kUsPerSecond + k * 300'000;
    const auto samples = sample_imu(motion, begin, begin + 300'000, 5000);
    ImuBuffer buffer;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      ImuSample sample = samples[i];
      sample.measured = i < 20 || i >= 40;
      if (!sample.measured) {
        sample.gyro.setZero();
        sample.accel = samples[19].accel;
      }
      buffer.add(sample);
    }
    const auto stretch = buffer.between(begin + 197'500, begin + 300'000);
    CHECK_FALSE(stretch.front().measured);
    CHECK(stretch[1].measured);
    const Preintegration whole(noise, {}, samples);
    const Preintegration bridged(noise, {}, buffer.between(begin, begin + 300'000));
    const Vector9d e = increment_error(bridged.increment(), whole.increment());
    told += e.dot(bridged.covariance().ldlt().solve(e)) / (9.0 * kRuns);
  }
  CHECK(told < 2.0);
}

TEST_CASE("Preintegration: where samples are lost, the covariance says how far off the increment may be") {
  const AnalyticMotion motion;
  const ImuNoise noise;
  double told = 0.0;
  double without_loss = 0.0;
  constexpr int kRuns = 20;
  for (int k = 0; k < kRuns; ++k) {
    const Utime begin = kUsPerSecond + k * 300'000;
    auto samples = sample_imu(motion, begin, begin + 500'000, 5000);
    const Preintegration whole(noise, {}, samples);
    samples.erase(samples.begin() + 30, samples.begin() + 70);  // 0.2 s
    const Preintegration torn(noise, {}, samples);
    const Vector9d e = increment_error(torn.increment(), whole.increment());
    told += e.dot(torn.covariance().ldlt().solve(e)) / (9.0 * kRuns);
    without_loss += e.dot(whole.covariance().ldlt().solve(e)) / (9.0 * kRuns);
  }
  CHECK(told < 2.0);
  CHECK(without_loss > 20.0);
}
