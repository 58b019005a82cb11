// SPDX-License-Identifier: BSD-3-Clause
#include "procs/sim/sensors.h"

#include <algorithm>
#include <vector>

#include "procs/sim/interrupt.h"
#include "procs/sim/progress.h"

namespace covey {
namespace {

constexpr Utime kStereoEveryUs = kUsPerSecond / sim::kStereoHz;
constexpr Utime kDepthEveryUs = kUsPerSecond / sim::kDepthHz;

imu_t to_message(const ImuSample& sample) {
  imu_t message{};
  message.utime = sample.utime;
  std::copy_n(sample.gyro.data(), 3, message.gyro);
  std::copy_n(sample.accel.data(), 3, message.accel);
  return message;
}

std::vector<SE3> poses_while_open(const sim::Ride& ride, const sim::ExposureOptions& exposure, Utime utime) {
  std::vector<SE3> poses;
  for (const Utime time : sim::open_times(exposure, utime))
    poses.push_back(ride.motion.at(std::clamp(time, ride.motion.begin, ride.motion.end)).T_W_B);
  return poses;
}

}  // namespace

void run_sensors(const sim::Ride& ride, sim::SensorCameras* cameras, bool has_depth, SensorSink& sink) {
  const Utime begin = ride.motion.begin;
  Progress progress("sensors", to_seconds(ride.motion.end - begin));
  Utime next_stereo = begin;
  Utime next_depth = begin;
  for (const ImuSample& sample : ride.imu.samples) {
    if (cameras && sample.utime >= next_stereo) {
      throw_if_interrupted();
      progress.show(to_seconds(next_stereo - begin));
      sink.write(
          cameras->stereo(poses_while_open(ride, cameras->options().exposure, next_stereo), next_stereo));
      next_stereo += kStereoEveryUs;
    }
    if (cameras && has_depth && sink.wants_depth() && sample.utime >= next_depth) {
      sink.write(cameras->depth(ride.motion.at(next_depth).T_W_B, next_depth));
      next_depth += kDepthEveryUs;
    }
    sink.write(to_message(sample));
  }
  sink.finish();
}

}  // namespace covey
