// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/start.h"

#include <catch2/catch.hpp>

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

constexpr Utime kFrameSpacing = 100'000;

std::vector<StartFrame> make_frames(const AnalyticMotion& motion, Utime from, const ImuBias& bias,
                                    const TrackSimOptions& options) {
  const Rig rig = stereo_rig();
  RandomGeometry random(options.seed);
  TrackSim sim(rig, options);
  auto imu = sample_imu(motion, from, from + 7 * kFrameSpacing, 5000);
  add_imu_errors(rig.imu, bias, random, imu);
  std::vector<StartFrame> frames;
  for (std::size_t k = 0; k < 8; ++k) {
    const Utime t = from + static_cast<Utime>(k) * kFrameSpacing;
    frames.push_back({sim.see(t, motion.state(t).T_W_B), {}});
    if (k > 0) frames.back().samples.assign(imu.begin() + 20 * (k - 1), imu.begin() + 20 * k + 1);
  }
  return frames;
}

}  // namespace

TEST_CASE("find_start: motion, velocity, gravity and gyro bias of a vehicle that stands or moves") {
  const ImuBias bias{{0.03, -0.08, 0.05}, {0.05, 0.05, -0.05}};
  for (const double still_s : {0.0, 100.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      AnalyticMotion motion;
      motion.still_s = still_s;
      const Utime from = static_cast<Utime>(seed) * 3 * kUsPerSecond;
      const auto frames = make_frames(motion, from, bias, {.seed = seed, .outliers = 0.1});
      const Start start = find_start(stereo_rig(), {}, frames);
      CAPTURE(still_s, seed, start.failure);
      REQUIRE(start.failure.empty());
      REQUIRE(start.states.size() == frames.size());
      REQUIRE(start.states[0].T_W_B.translation.norm() < 1e-9);
      const SE3 T_O_W = start.states[0].T_W_B * motion.state(from).T_W_B.inverse();
      for (std::size_t k = 0; k < frames.size(); ++k) {
        const NavState truth = motion.state(frames[k].tracks.utime);
        const SE3 error = start.states[k].T_W_B.inverse() * T_O_W * truth.T_W_B;
        REQUIRE(error.translation.norm() < 0.03);
        REQUIRE(error.rotation.log().norm() < 0.01);
        REQUIRE((start.states[k].v_W - T_O_W.rotation * truth.v_W).norm() < 0.1);
        REQUIRE((start.states[k].bias.gyro - bias.gyro).norm() < 0.01);
        const Eigen::Vector3d up = start.states[k].T_W_B.rotation.inverse() * Eigen::Vector3d::UnitZ();
        REQUIRE((up - truth.T_W_B.rotation.inverse() * Eigen::Vector3d::UnitZ()).norm() < 0.06);
      }
    }
  }
}

TEST_CASE("find_start: says why it cannot") {
  const AnalyticMotion motion;
  auto frames = make_frames(motion, 0, {}, {});
  REQUIRE_FALSE(find_start(stereo_rig(), {}, std::span(frames).first(2)).failure.empty());
  auto heavy = frames;
  for (StartFrame& frame : heavy) {
    for (ImuSample& sample : frame.samples) sample.accel *= 1.5;
  }
  REQUIRE(find_start(stereo_rig(), {}, heavy).failure == "images and accelerometer do not agree");
  frames[4].tracks.tracks.clear();
  REQUIRE(find_start(stereo_rig(), {}, frames).failure == "too few tracks that agree");
}
