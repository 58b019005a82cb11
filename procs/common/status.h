// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a process counts and measures; becomes STATUS once a second and at every change of phase.
// Names are paths: "in/KEYFRAME", "out/TRAJECTORY", "dropped/KEYFRAME/undecodable"; a gauge carries its unit:
// "solve_ms".

#include <covey/status_t.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/base/time.h"

namespace covey {

class Status {
 public:
  void count(const std::string& name, std::int64_t n = 1) { counters_[name] += n; }
  void set_counter(const std::string& name, std::int64_t total) { counters_[name] = total; }
  void gauge(const std::string& name, double value) { gauges_[name] = value; }
  // One of many measurements, e.g. of a latency: STATUS says name_mean, name_p99 and name_max of the last
  // 256.
  void sample(const std::string& name, double value);
  // One word. Process publishes STATUS at once when it changes.
  void set_phase(const std::string& phase);

  std::int64_t counter(const std::string& name) const;
  double gauge(const std::string& name) const;  // 0 where it was never set
  const std::string& phase() const { return phase_; }
  void on_phase_change(std::function<void()> handler) { on_phase_change_ = std::move(handler); }

  // Everything but process, robot and start_utime.
  status_t to_message(Utime now) const;

 private:
  struct Samples {
    std::vector<double> last;
    std::size_t next = 0;
  };

  std::string phase_ = "starting";
  std::map<std::string, std::int64_t> counters_;
  std::map<std::string, double> gauges_;
  std::map<std::string, Samples> samples_;
  std::function<void()> on_phase_change_;
};

// Datagrams that the kernel dropped for want of room, by local port, over the UDP sockets of this process.
std::map<int, std::int64_t> kernel_drops();
// Resident memory of this process, in MB (10^6 bytes).
double resident_mb();

}  // namespace covey
