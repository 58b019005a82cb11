// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include "procs/common/bus.h"
#include "procs/common/channels.h"
#include "procs/common/event_loop.h"
#include "procs/common/status.h"
#include "procs/sim/interrupt.h"
#include "procs/sim/sink.h"

namespace covey {
namespace {

class BusSink : public SensorSink {
 public:
  explicit BusSink(const SimOptions& options)
      : speed_(options.speed), sensors_({.url = options.url, .faults = {}, .recorder = {}}, loop_, status_) {
    loop_.handle_signals();
    if (!options.depth_url.empty() && options.depth_url != options.url) {
      depth_ = std::make_unique<Bus>(BusOptions{.url = options.depth_url, .faults = {}, .recorder = {}},
                                     loop_, status_);
    }
  }

  void write(const imu_t& imu) override {
    wait_for(imu.utime);
    sensors_.publish(kImu, imu);
  }
  void write(const stereo_t& stereo) override {
    wait_for(stereo.utime);
    sensors_.publish(kStereo, stereo);
  }
  void write(const depth_t& depth) override {
    wait_for(depth.utime);
    (depth_ ? *depth_ : sensors_).publish(kDepth, depth);
  }
  void finish() override {
    constexpr Utime kLastBandsUs = 100'000;
    run_until(loop_.now() + kLastBandsUs);
  }

 private:
  void wait_for(Utime utime) {
    if (first_ == 0) {
      first_ = utime;
      start_ = loop_.now();
    }
    run_until(start_ + from_seconds(to_seconds(utime - first_) / speed_));
  }

  // Bands go out, and signals are heard, while nothing is due; and at least once where everything is late.
  void run_until(Utime time) {
    loop_.call_at(time, [this] { loop_.stop(); });
    loop_.run();
    if (loop_.interrupted()) throw Interrupted();
  }

  double speed_;
  EventLoop loop_;
  Status status_;
  Bus sensors_;
  std::unique_ptr<Bus> depth_;  // where it is another one
  Utime first_ = 0;
  Utime start_ = 0;
};

}  // namespace

std::unique_ptr<SensorSink> make_bus_sink(const SimOptions& options) {
  return std::make_unique<BusSink>(options);
}

}  // namespace covey
