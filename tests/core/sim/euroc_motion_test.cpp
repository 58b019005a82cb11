// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/euroc_motion.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "core/base/error.h"
#include "core/sim/drive.h"
#include "tests/core/graph/factor_testing.h"
#include "tests/data.h"

namespace covey::sim {
namespace {

constexpr double kDegree = M_PI / 180.0;

// A drive, its IMU, and a ground truth of it that is noisy, tilted against gravity and jumps aside for half a second.
struct Synthetic {
  Motion motion;
  EurocSequence sequence;
  SO3 R_G_W;
};

Synthetic synthetic(double jump_m, double tilt_deg) {
  const std::vector<Eigen::Vector3d> path = {{0, 0, 0}, {8, 0, 0}, {8, -8, 0}, {0, -8, 0}, {0, 20, 0}};
  Synthetic s;
  s.motion = drive(path, {.bounce_m = 0.002, .sway_deg = 1.0}, 1'000'000'000, 20.0, 3);
  s.R_G_W = SO3::exp({tilt_deg * kDegree, 0.0, 0.0});
  s.sequence.imu = simulate_imu(s.motion, {}, 4).samples;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const Eigen::Vector3d middle = s.motion.at(1'010'000'000).T_W_B.translation;
  for (Utime t = s.motion.begin; t <= s.motion.end; t += 5'000) {
    const SE3 T_W_B = s.motion.at(t).T_W_B;
    Eigen::Vector3d p = middle + s.R_G_W * Eigen::Vector3d(T_W_B.translation - middle);
    for (int k = 0; k < 3; ++k) p[k] += 0.001 * normal(random);
    if (t >= 1'009'000'000 && t < 1'009'500'000) p.z() += jump_m;
    const Eigen::Vector3d turn(normal(random), normal(random), normal(random));
    s.sequence.truth.push_back({t, {s.R_G_W * T_W_B.rotation * SO3::exp(0.1 * kDegree * turn), p}});
  }
  return s;
}

EurocMotion smooth(const Synthetic& s) { return smooth_euroc(s.sequence, s.motion.begin, s.motion.end, {}); }

// Of positions, after their mean is taken away: where the tilted world's origin is, nobody can tell.
double rms_to(const Motion& truth, const Motion& motion) {
  std::vector<Eigen::Vector3d> errors;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (Utime t = truth.begin; t <= truth.end; t += 20'000) {
    errors.emplace_back(motion.at(t).T_W_B.translation - truth.at(t).T_W_B.translation);
    mean += errors.back();
  }
  mean /= static_cast<double>(errors.size());
  double sum = 0.0;
  for (const Eigen::Vector3d& error : errors) sum += (error - mean).squaredNorm();
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

TEST_CASE("ground-truth factors have the Jacobians that they say") {
  const SE3 T_W_B{SO3::exp({0.3, -0.8, 1.1}), {1.0, -2.0, 0.5}};
  const Eigen::Vector2d tilt(0.02, -0.05);
  const graph::Key pose{'x', 0};
  const graph::Key world{'t', 0};
  graph::Values values;
  values.set(pose, T_W_B);
  values.set(world, graph::Vector<2>(tilt));
  graph::Graph graph;
  graph.add(TiltedPosition{{1.1, -1.9, 0.7}, {0.2, 0.3, 0.1}}, {pose, world});
  graph.add(TiltedRotation{SO3::exp({0.2, -0.7, 1.3})}, {pose, world});
  for (const graph::FactorId id : graph.ids())
    CHECK(graph::testing::jacobian_error(graph.factor(id), values) < 1e-6);
}

TEST_CASE("the smoother finds the motion under a ground truth with noise, tilt and a jump") {
  const Synthetic s = synthetic(0.05, 0.3);
  const EurocMotion smoothed = smooth(s);
  CHECK(smoothed.evidence.tilt_deg == Approx(0.3).margin(0.06));
  // Tilt and jump are in the ground truth, and not in the motion.
  CHECK(smoothed.evidence.truth_rms_m > 0.010);
  CHECK(rms_to(s.motion, smoothed.motion) < 0.003);
  CHECK(smoothed.evidence.misfit_median_m < 0.002);
  CHECK(smoothed.evidence.misfit_max_m < 0.006);
}

TEST_CASE("without a jump it comes nearer than the ground truth's own noise") {
  const Synthetic s = synthetic(0.0, 0.0);
  const EurocMotion smoothed = smooth(s);
  CHECK(rms_to(s.motion, smoothed.motion) < 0.001);
  CHECK(smoothed.evidence.truth_rms_m < 0.003);
  CHECK(smoothed.evidence.misfit_median_m < 0.0015);
  const ImuRecord true_imu = simulate_imu(s.motion, {}, 4);
  const std::size_t middle = true_imu.biases.size() / 2;
  CHECK((smoothed.imu.biases[middle].gyro - true_imu.biases[middle].gyro).norm() < 2e-3);
  CHECK((smoothed.imu.biases[middle].accel - true_imu.biases[middle].accel).norm() < 0.05);
}

TEST_CASE("the smoothed motion is one: its derivatives fit its positions, between samples and across nodes") {
  const EurocMotion smoothed = smooth(synthetic(0.05, 0.1));
  const Motion& motion = smoothed.motion;
  const Utime h = 1'000;
  const double span = to_seconds(2 * h);
  for (Utime t = motion.begin + h; t + h <= motion.end; t += 7'313) {
    const MotionState a = motion.at(t - h);
    const MotionState state = motion.at(t);
    const MotionState b = motion.at(t + h);
    CHECK(((b.T_W_B.translation - a.T_W_B.translation) / span - state.v_W).norm() < 2e-3);
    CHECK(((a.T_W_B.rotation.inverse() * b.T_W_B.rotation).log() / span - state.omega_B).norm() < 0.03);
  }
}

TEST_CASE("a part of a motion begins where it is told to, with its samples") {
  const Synthetic s = synthetic(0.0, 0.0);
  const EurocMotion whole = smooth(s);
  const EurocMotion part = cut(whole, 1'004'000'000, 1'014'000'000, 77'000'000);
  CHECK(part.motion.begin == 77'000'000);
  CHECK(part.motion.end == 87'000'000);
  CHECK(part.imu.samples.size() == 2001);
  CHECK(part.imu.biases.size() == 2001);
  CHECK(part.imu.samples.front().utime == 77'000'000);
  CHECK(part.motion.at(78'000'123).T_W_B.translation == whole.motion.at(1'005'000'123).T_W_B.translation);
}

TEST_CASE("a stretch that is not covered is refused, and take-off is found") {
  const Synthetic s = synthetic(0.0, 0.0);
  CHECK_THROWS_AS(smooth_euroc(s.sequence, s.motion.begin - 1'000'000, s.motion.end, {}), InputError);
  CHECK_THROWS_AS(smooth_euroc(s.sequence, s.motion.begin, s.motion.end + 1'000'000, {}), InputError);
  // It stands for 1.25 s and needs 0.35 s for the first 5 cm.
  CHECK(to_seconds(take_off(s.sequence.truth) - s.motion.begin) == Approx(1.6).margin(0.1));
}

TEST_CASE("a real sequence: near its ground truth, and explained by its IMU") {
  const auto folder = test_data("euroc/motion/V1_02_medium");
  if (!folder) return;
  const EurocSequence sequence = read_euroc_sequence(*folder);
  const Utime from = take_off(sequence.truth);
  const EurocMotion smoothed =
      smooth_euroc(sequence, from, from + 30'000'000, euroc_options("V1_02_medium", {}));
  CHECK(smoothed.evidence.truth_rms_m < 0.012);
  CHECK(smoothed.evidence.truth_rms_m > 0.0005);
  CHECK(smoothed.evidence.misfit_median_m < 0.0025);
  CHECK(smoothed.evidence.misfit_max_m < 0.007);
  CHECK(smoothed.evidence.tilt_deg < 0.5);
}

}  // namespace
}  // namespace covey::sim
