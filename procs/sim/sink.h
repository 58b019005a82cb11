// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where a robot's sensor data go, in order of time: a log, a folder in EuRoC's layout, a bus.

#include <covey/depth_t.hpp>
#include <covey/imu_t.hpp>
#include <covey/stereo_t.hpp>
#include <filesystem>
#include <memory>

#include "core/geometry/rig.h"
#include "core/sim/scenario.h"
#include "procs/sim/simulate.h"

namespace covey {

class SensorSink {
 public:
  SensorSink() = default;
  virtual ~SensorSink() = default;
  SensorSink(const SensorSink&) = delete;
  SensorSink& operator=(const SensorSink&) = delete;

  virtual bool wants_depth() const { return true; }
  virtual void write(const imu_t& imu) = 0;
  virtual void write(const stereo_t& stereo) = 0;
  virtual void write(const depth_t& depth) = 0;
  // All is written. What is not finished leaves nothing under its final name.
  virtual void finish() = 0;
};

// FILE, with its events in order of time, the bands of an image set kBandSpacingUs apart. The same data give the same bytes.
std::unique_ptr<SensorSink> make_log_sink(const std::filesystem::path& file);

// DIR/mav0, which must not be there yet: cam0, cam1, imu0, state_groundtruth_estimate0.
std::unique_ptr<SensorSink> make_asl_sink(const std::filesystem::path& folder, const Rig& rig,
                                          const sim::Ride& ride);

// As they would come from sensors, `speed` times as fast, or as fast as they are made where that is slower.
std::unique_ptr<SensorSink> make_bus_sink(const SimOptions& options);

}  // namespace covey
