// SPDX-License-Identifier: BSD-3-Clause
// Time of visual-inertial odometry by stage, CPU of one core: what a frame costs in the front end and in the estimator, an IMU sample with the state that is told
// after it, and the whole frame; median, 99th percentile and most. On EuRoC's clip where the data folder is there, and the estimator alone on the tracks of
// a generated room.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <opencv2/core/utility.hpp>

#include "core/vio/estimator.h"
#include "core/vision/stereo_front_end.h"
#include "procs/player/asl_folder.h"
#include "tests/core/vio/tracks.h"
#include "tests/data.h"

using namespace covey;

namespace {

constexpr double kRoomS = 30.0;
constexpr Utime kStepUs = 5'000;
constexpr int kSamplesPerFrame = 10;

double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Stage {
 public:
  template <typename Work>
  auto time(const Work& work) {
    const double began = cpu_ms();
    auto result = work();
    ms_.push_back(cpu_ms() - began);
    return result;
  }
  double last() const { return ms_.back(); }
  void add(double ms) { ms_.push_back(ms); }
  void tell(benchmark::State& state, const std::string& name) {
    if (ms_.empty()) return;
    std::sort(ms_.begin(), ms_.end());
    const double last = static_cast<double>(ms_.size() - 1);
    state.counters[name + "_p50_ms"] = ms_[static_cast<std::size_t>(0.5 * last)];
    state.counters[name + "_p99_ms"] = ms_[static_cast<std::size_t>(0.99 * last)];
    state.counters[name + "_max_ms"] = ms_.back();
  }

 private:
  std::vector<double> ms_;
};

struct Stages {
  Stage front_end, estimator, imu, frame;
  void tell(benchmark::State& state) {
    front_end.tell(state, "front_end");
    estimator.tell(state, "estimator");
    imu.tell(state, "imu");
    frame.tell(state, "frame");
  }
};

void sample(vio::VioEstimator& estimator, const ImuSample& sample, Stages& stages) {
  stages.imu.time([&] {
    estimator.add_imu(sample);
    return estimator.predict().has_value();
  });
}

void room(benchmark::State& state) {
  const Rig rig = testing::stereo_rig();
  Stages stages;
  for (auto _ : state) {
    const testing::AnalyticMotion motion;
    testing::TrackSim sim(rig, {});
    vio::VioEstimator estimator(rig, {});
    for (int k = 0; k * to_seconds(kStepUs) < kRoomS; ++k) {
      const Utime utime = kUsPerSecond + k * kStepUs;
      sample(estimator, motion.imu(utime), stages);
      if (k % kSamplesPerFrame != 0) continue;
      const FrameTracks tracks = sim.see(utime, motion.state(utime).T_W_B);
      stages.estimator.time([&] { return estimator.add_frame(tracks).states.size(); });
    }
  }
  stages.tell(state);
}

ImuSample sample_of(const imu_t& message) {
  return {message.utime, Eigen::Vector3d(message.gyro), Eigen::Vector3d(message.accel)};
}

void clip(benchmark::State& state) {
  const auto folder = test_data("euroc/mh01_clip");
  if (!folder) return state.SkipWithError("no data");
  cv::setNumThreads(1);
  const Rig rig = read_rig(std::filesystem::path(COVEY_SOURCE_DIR) / "configs/sensors/euroc.yaml");
  const AslFolder recording = read_asl(*folder);
  Stages stages;
  for (auto _ : state) {
    StereoFrontEnd front_end(rig, {});
    vio::VioEstimator estimator(rig, {});
    auto next = recording.imu.begin();
    for (const AslPicture& picture : recording.pictures) {
      for (; next != recording.imu.end() && estimator.imu_until() < picture.utime; ++next)
        sample(estimator, sample_of(*next), stages);
      const stereo_t stereo = load_stereo(picture);
      const Utime before = front_end.compared_with().value_or(picture.utime);
      const FrontEndFrame seen = stages.front_end.time([&] {
        return front_end.process({stereo.utime, stereo.width, stereo.height, stereo.left, stereo.right},
                                 estimator.predict_rotation(before, picture.utime));
      });
      stages.estimator.time([&] { return estimator.add_frame(seen.tracks).states.size(); });
      stages.frame.add(stages.front_end.last() + stages.estimator.last());
    }
  }
  stages.tell(state);
}

BENCHMARK(room)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(clip)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
