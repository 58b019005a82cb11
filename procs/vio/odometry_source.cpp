// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/odometry_source.h"

#include "procs/common/channels.h"
#include "procs/vio/messages.h"

namespace covey {

OdometrySource::OdometrySource(Process& process, const VioProcessOptions& options, VioOutput& output)
    : process_(process), output_(output), odometry_(options.estimator, options.odometry) {
  process_.sensor_bus().subscribe(kOdometry, [this](const odometry_t& message) { on_odometry(message); });
  process_.status().set_phase("waiting");
}

void OdometrySource::on_odometry(const odometry_t& message) {
  const auto pose = odometry_from(message);
  if (!pose) return drop("values");
  const vio::VioFrame frame = odometry_.add(*pose);
  if (frame.dropped != nullptr) return drop(frame.dropped);
  process_.status().count("frames");
  for (const vio::VioState& state : frame.states) {
    output_.publish_state(state);
    output_.add_to_trajectory(state);
  }
  for (const vio::VioKeyframe& keyframe : frame.keyframes) output_.publish_keyframe(keyframe);
  process_.status().set_phase("tracking");
}

void OdometrySource::drop(const char* reason) {
  process_.status().count(fmt::format("dropped/{}/{}", kOdometry.name, reason));
}

}  // namespace covey
