// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/estimator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "core/eval/ate.h"
#include "tests/core/vio/tracks.h"

using namespace covey;
using namespace covey::vio;
using covey::testing::add_imu_errors;
using covey::testing::AnalyticMotion;
using covey::testing::RandomGeometry;
using covey::testing::sample_imu;
using covey::testing::stereo_rig;
using covey::testing::TrackSim;
using covey::testing::TrackSimOptions;

namespace {

constexpr Utime kStart = 1'000 * kUsPerSecond;
constexpr Utime kFrame = 50'000;
const ImuBias kBias{{0.02, -0.03, 0.08}, {0.05, -0.1, 0.08}};

struct Run {
  AnalyticMotion motion;
  int frames = 0;
  std::vector<VioState> states;
  std::vector<VioState> predictions;
  std::vector<VioKeyframe> keyframes;
  std::vector<VioHealth> healths;
};

// What happens to a frame on its way: it may be changed, or lost (false).
using Treatment = std::function<bool(double time_s, TrackSim& sim, FrameTracks& frame)>;

// Seconds without IMU; frames of that time do not get through either, unless they go on without.
struct ImuAway {
  double from_s = 0.0;
  double until_s = 0.0;
  bool frames = false;
};

Run run(const AnalyticMotion& motion, double seconds, const TrackSimOptions& options,
        const Treatment& treatment = {}, const ImuAway& away = {}, const Rig& rig = stereo_rig()) {
  RandomGeometry random(options.seed + 100);
  auto imu = sample_imu(motion, kStart, kStart + from_seconds(seconds), 5000);
  add_imu_errors(rig.imu, kBias, random, imu);
  TrackSim sim(rig, options);
  VioEstimator estimator(rig, {});
  Run result{motion, 0, {}, {}, {}, {}};
  for (const ImuSample& sample : imu) {
    const double now_s = to_seconds(sample.utime - kStart);
    const bool is_frame = (sample.utime - kStart) % kFrame == 0;
    if (now_s > away.from_s && now_s < away.until_s) {
      if (!away.frames || !is_frame) continue;
      estimator.bridge_imu(sample.utime);
    } else {
      estimator.add_imu(sample);
    }
    if (const auto state = estimator.predict()) result.predictions.push_back(*state);
    if (!is_frame) continue;
    FrameTracks frame = sim.see(sample.utime, motion.state(sample.utime).T_W_B);
    ++result.frames;
    if (treatment && !treatment(to_seconds(sample.utime - kStart), sim, frame)) continue;
    const VioFrame out = estimator.add_frame(frame);
    result.states.insert(result.states.end(), out.states.begin(), out.states.end());
    result.keyframes.insert(result.keyframes.end(), out.keyframes.begin(), out.keyframes.end());
    result.healths.push_back(out.health);
  }
  return result;
}

AnalyticMotion still_first() {
  AnalyticMotion motion;
  motion.still_s = to_seconds(kStart) + 2.0;
  return motion;
}

double ate_m(const Run& r) {
  TrajectoryPair pair;
  for (const VioState& state : r.states) {
    pair.estimate.push_back({state.utime, state.state.T_W_B});
    pair.reference.push_back({state.utime, r.motion.state(state.utime).T_W_B});
  }
  const TrajectoryError error = trajectory_error(pair);
  REQUIRE(error.matched == static_cast<int>(r.states.size()));
  return error.rmse_m;
}

// The truth in O, which the estimate fixes at its first state: position and the turn about the vertical.
SE3 world_in_odometry(const Run& r) {
  const VioState& first = r.states.front();
  const SE3 T_W_B = r.motion.state(first.utime).T_W_B;
  const Eigen::Matrix3d R = (first.state.T_W_B.rotation * T_W_B.rotation.inverse()).matrix();
  const SO3 yaw = SO3::exp({0.0, 0.0, std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1))});
  return {yaw, first.state.T_W_B.translation - yaw * T_W_B.translation};
}

double mean_state_nees(const Run& r, const std::vector<VioState>& states) {
  const SE3 T_O_W = world_in_odometry(r);
  double sum = 0.0;
  for (const VioState& state : states) {
    const NavState truth = r.motion.state(state.utime);
    Vector9d e;
    e << (state.state.T_W_B.inverse() * T_O_W * truth.T_W_B).log(),
        T_O_W.rotation * truth.v_W - state.state.v_W;
    sum += e.dot(state.covariance.ldlt().solve(e));
  }
  return sum / static_cast<double>(states.size());
}

double mean_keyframe_nees(const Run& r) {
  double sum = 0.0;
  for (std::size_t k = 1; k < r.keyframes.size(); ++k) {
    const SE3 truth =
        r.motion.state(r.keyframes[k - 1].utime).T_W_B.inverse() * r.motion.state(r.keyframes[k].utime).T_W_B;
    const Vector6d e = (r.keyframes[k].T_P_K.inverse() * truth).log();
    sum += e.dot(r.keyframes[k].covariance.ldlt().solve(e));
  }
  return sum / static_cast<double>(r.keyframes.size() - 1);
}

double worst_gravity_error_sigmas(const Run& r) {
  double worst = 0.0;
  for (const VioKeyframe& keyframe : r.keyframes) {
    const Eigen::Vector3d truth =
        r.motion.state(keyframe.utime).T_W_B.rotation.inverse() * Eigen::Vector3d(0, 0, -1);
    worst = std::max(worst, (keyframe.gravity_K - truth).norm() / keyframe.gravity_sigma_rad);
  }
  return worst;
}

void check_bookkeeping(const Run& r) {
  REQUIRE(r.healths.back().segments == 1);
  for (std::size_t k = 0; k < r.keyframes.size(); ++k) {
    const VioKeyframe& keyframe = r.keyframes[k];
    REQUIRE(keyframe.id == static_cast<int>(k));
    REQUIRE(keyframe.segment == r.states.front().utime);
    REQUIRE(keyframe.gravity_K.norm() == Approx(1.0));
    if (k == 0) continue;
    REQUIRE(keyframe.utime > r.keyframes[k - 1].utime);
    REQUIRE(keyframe.covariance.ldlt().isPositive());
    REQUIRE(to_seconds(keyframe.utime - r.keyframes[k - 1].utime) < 1.001);
    const SE3 step = keyframe.T_P_K;
    REQUIRE(step.translation.norm() < 0.7);
    REQUIRE(step.rotation.log().norm() < 0.45);
  }
  for (std::size_t k = 1; k < r.states.size(); ++k) REQUIRE(r.states[k].utime > r.states[k - 1].utime);
}

}  // namespace

TEST_CASE("VioEstimator: starts standing and follows a motion") {
  const Run r = run(still_first(), 20.0, {});
  check_bookkeeping(r);
  REQUIRE(r.states.size() >= 0.97 * r.frames);
  REQUIRE(ate_m(r) < 0.02);
  REQUIRE(mean_state_nees(r, r.states) < 18.0);
  REQUIRE(mean_keyframe_nees(r) < 12.0);
  REQUIRE(worst_gravity_error_sigmas(r) < 4.0);
  REQUIRE((r.states.back().state.bias.gyro - kBias.gyro).norm() < 2e-3);
  const SE3& first = r.states.front().state.T_W_B;
  REQUIRE(first.translation.norm() < 1e-3);
}

TEST_CASE("VioEstimator: starts in motion, and the IMU-rate states are as good as their covariance says") {
  const Run r = run(AnalyticMotion{}, 20.0, {.seed = 2});
  check_bookkeeping(r);
  REQUIRE(r.states.size() >= 0.97 * r.frames);
  REQUIRE(ate_m(r) < 0.02);
  REQUIRE(mean_state_nees(r, r.states) < 18.0);
  REQUIRE(mean_keyframe_nees(r) < 12.0);
  REQUIRE(worst_gravity_error_sigmas(r) < 4.0);
  REQUIRE(r.predictions.size() > 3500);
  REQUIRE(mean_state_nees(r, r.predictions) < 18.0);
}

TEST_CASE("VioEstimator: a tenth of the tracks slide over the scene, and do not take the estimate along") {
  const Run r = run(AnalyticMotion{}, 20.0, {.seed = 3, .outliers = 0.1});
  check_bookkeeping(r);
  REQUIRE(ate_m(r) < 0.03);
  int outliers = 0;
  for (const VioHealth& health : r.healths) outliers += health.outliers;
  REQUIRE(outliers > 0);
}

TEST_CASE("VioEstimator: a second without images is bridged by the IMU, which says so") {
  const auto dark = [](double t, TrackSim& sim, FrameTracks&) {
    const bool lost = t > 8.0 && t < 9.0;
    if (lost) sim.lose_all();
    return !lost;
  };
  const Run r = run(AnalyticMotion{}, 15.0, {.seed = 4}, dark);
  REQUIRE(r.healths.back().segments == 1);
  REQUIRE(ate_m(r) < 0.04);
  int coasting = 0;
  for (const VioState& state : r.predictions) coasting += state.coasting;
  REQUIRE(coasting > 100);
  REQUIRE(coasting < 260);
  REQUIRE_FALSE(r.states.back().coasting);
}

TEST_CASE("VioEstimator: half a second without IMU is bridged by the pictures") {
  for (const double length_s : {0.15, 0.5}) {
    const Run r = run(AnalyticMotion{}, 12.0, {.seed = 6}, {}, {8.0, 8.0 + length_s});
    CAPTURE(length_s);
    CHECK(r.healths.back().segments == 1);
    CHECK(ate_m(r) < 0.03);
  }
}

TEST_CASE("VioEstimator: frames bridge a whole second without IMU, and more than they may not") {
  const Run r = run(AnalyticMotion{}, 6.5, {.seed = 6}, {}, {4.0, 5.0, true});
  CHECK(r.healths.back().segments == 1);
  CHECK(ate_m(r) < 0.03);
  CHECK(r.healths.back().phase == VioPhase::kTracking);
  for (std::size_t k = 1; k < r.states.size(); ++k)
    REQUIRE(r.states[k].utime - r.states[k - 1].utime == kFrame);
  const Run longer = run(AnalyticMotion{}, 5.0, {.seed = 6}, {}, {2.0, 4.2, true});
  CHECK(longer.healths.back().segments == 2);
  CHECK(longer.healths.back().trouble == "too long without IMU");
}

TEST_CASE("VioEstimator: without images and IMU a segment ends soon") {
  const auto dark = [](double t, TrackSim& sim, FrameTracks& frame) {
    if (t > 3.0 && t < 4.0) {
      sim.lose_all();
      frame.tracks.clear();
    }
    return true;
  };
  const Run r = run(AnalyticMotion{}, 5.0, {.seed = 6}, dark, {3.0, 4.0, true});
  CHECK(r.healths.back().segments == 2);
  CHECK(r.healths.back().trouble == "neither images nor IMU");
}

TEST_CASE("VioEstimator: a knock that drives the IMU to the end of its range is told and survived") {
  Rig rig = stereo_rig();
  rig.imu.gyro_range = 17.4;
  rig.imu.accel_range = 176.0;
  const AnalyticMotion motion;
  VioEstimator estimator(rig, {});
  TrackSim sim(rig, {});
  int saturated = 0;
  SE3 T_O_W;
  for (Utime t = kStart; t <= kStart + 6 * kUsPerSecond; t += 5000) {
    ImuSample sample = motion.imu(t);
    const double s = to_seconds(t - kStart);
    if (s > 4.0 && s < 4.2) sample = {t, {17.45, -17.45, 17.45}, {176.6, 176.6, -176.6}};
    const char* reason = estimator.add_imu(sample);
    saturated += reason != nullptr && std::string(reason) == "saturated" ? 1 : 0;
    if ((t - kStart) % kFrame != 0) continue;
    const SE3 T_W_B = motion.state(t).T_W_B;
    const VioFrame out = estimator.add_frame(sim.see(t, T_W_B));
    if (out.states.empty()) continue;
    const SE3 T_O_B = out.states.back().state.T_W_B;
    if (s < 3.9) T_O_W = T_O_B * T_W_B.inverse();
    if (s > 4.0) REQUIRE((T_O_W * T_W_B.translation - T_O_B.translation).norm() < 0.05);
  }
  CHECK(saturated == 39);
  CHECK(estimator.health().segments == 1);
}

TEST_CASE("VioEstimator: samples with false stamps are refused, and a gap is believed at the second sample") {
  const Rig rig = stereo_rig();
  const AnalyticMotion motion;
  VioEstimator estimator(rig, {});
  TrackSim sim(rig, {});
  std::map<std::string, int> refused;
  int count = 0;
  for (Utime t = kStart; t <= kStart + 6 * kUsPerSecond; t += 5000) {
    const double s = to_seconds(t - kStart);
    if (s > 4.0 && s < 4.2) continue;
    ImuSample sample = motion.imu(t);
    if (++count % 40 == 0) sample.utime += count % 80 == 0 ? 10 * kUsPerSecond : -kUsPerSecond;
    if (const char* reason = estimator.add_imu(sample)) ++refused[reason];
    if ((t - kStart) % kFrame == 0) estimator.add_frame(sim.see(t, motion.state(t).T_W_B));
  }
  CHECK(estimator.health().segments == 1);
  CHECK(refused == std::map<std::string, int>{{"ahead", 15}, {"late", 15}});
}

TEST_CASE("VioEstimator: frames without tracks coast, too long a time of them opens a new segment") {
  const auto dark = [](double t, TrackSim& sim, FrameTracks& frame) {
    if (t > 5.0 && t < 10.0) {
      sim.lose_all();
      frame.tracks.clear();
    }
    return true;
  };
  const Run r = run(AnalyticMotion{}, 14.0, {.seed = 5}, dark);
  REQUIRE(r.healths.back().segments == 2);
  REQUIRE(r.healths.back().trouble == "too long without images");
  REQUIRE(r.healths.back().phase == VioPhase::kTracking);
  REQUIRE(r.keyframes.back().segment > kStart + 9 * kUsPerSecond);
  int id = 0;
  for (std::size_t k = 0; k < r.keyframes.size(); ++k, ++id) {
    if (k > 0 && r.keyframes[k].segment != r.keyframes[k - 1].segment) id = 0;
    REQUIRE(r.keyframes[k].id == id);
  }
  REQUIRE(id > 3);
}

TEST_CASE("VioEstimator: what cannot be used is named and does no harm") {
  const Rig rig = stereo_rig();
  const AnalyticMotion motion;
  VioEstimator estimator(rig, {});
  TrackSim sim(rig, {});
  REQUIRE(std::string(estimator.add_frame({kStart, {}}).dropped) == "ahead_of_imu");
  REQUIRE_FALSE(estimator.predict());
  REQUIRE(estimator.predict_rotation(kStart, kStart + 1000).log().norm() == 0.0);
  int segments = 0;
  for (Utime t = kStart; t <= kStart + 6 * kUsPerSecond; t += 5000) {
    const double s = to_seconds(t - kStart);
    if (s > 3.0 && s < 3.79) continue;  // the IMU is away
    estimator.add_imu(motion.imu(t));
    estimator.add_imu(motion.imu(t));
    ImuSample bad = motion.imu(t + 1);
    bad.gyro.x() = std::numeric_limits<double>::infinity();
    REQUIRE(std::string(estimator.add_imu(bad)) == "not_finite");
    if ((t - kStart) % kFrame != 0) continue;
    FrameTracks frame = sim.see(t, motion.state(t).T_W_B);
    if (!frame.tracks.empty()) {
      frame.tracks.front().left.x() = std::numeric_limits<double>::quiet_NaN();
      frame.tracks.push_back(frame.tracks[frame.tracks.size() / 2]);
      frame.tracks.back().left.setZero();
    }
    REQUIRE(std::string(estimator.add_frame({t + kFrame, frame.tracks}).dropped) == "ahead_of_imu");
    const VioFrame out = estimator.add_frame(frame);
    REQUIRE((out.dropped == nullptr || std::string(out.dropped) == "imu_gap"));
    segments = out.health.segments;
    REQUIRE(std::string(estimator.add_frame(frame).dropped) == "late");
    REQUIRE(estimator.add_frame({t - kFrame, {}}).states.empty());
    if (const auto state = estimator.predict()) REQUIRE(state->state.T_W_B.translation.norm() < 10.0);
  }
  REQUIRE(segments == 2);  // the second after the IMU was away
}

TEST_CASE("VioEstimator: a clock that goes back opens a new segment") {
  const Rig rig = stereo_rig();
  const AnalyticMotion motion;
  VioEstimator estimator(rig, {});
  TrackSim sim(rig, {});
  for (const Utime from : {kStart, kStart / 2}) {
    for (Utime t = from; t <= from + 4 * kUsPerSecond; t += 5000) {
      estimator.add_imu(motion.imu(t));
      if ((t - from) % kFrame == 0) estimator.add_frame(sim.see(t, motion.state(t).T_W_B));
    }
  }
  REQUIRE(estimator.health().segments == 2);
  REQUIRE(estimator.predict()->segment < kStart);
}

TEST_CASE("VioEstimator: one camera starts when motion tells the scale, and keeps it") {
  Rig rig = stereo_rig();
  rig.right.reset();
  const Run r = run(still_first(), 12.0, {.seed = 7}, {}, {}, rig);
  CAPTURE(r.healths.back().no_start);
  REQUIRE(r.healths.back().segments == 1);
  const auto started = std::find_if(r.healths.begin(), r.healths.end(),
                                    [](const VioHealth& health) { return health.segments > 0; });
  CHECK(started - r.healths.begin() > 40);  // it stands for two seconds
  CHECK(started - r.healths.begin() < 80);
  CHECK(ate_m(r) < 0.06);
  CHECK(mean_keyframe_nees(r) < 12.0);
}
