// SPDX-License-Identifier: BSD-3-Clause
// A small process for the tests of procs/common: writes a stream of keyframes, or reads it into a text file,
// one line "segment id" for each. A reader also answers every TRAJECTORY with one LOOP_WEIGHTS of the same
// round, so that there is an output, and says its time every 100 ms in another, so that there is a timer.
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <fstream>

#include "procs/common/process.h"

namespace covey {
namespace {

struct ProbeOptions {
  int write = 0;
  int period_ms = 2;
  std::int64_t segment = 1'000'000;
  std::string read;
  bool stuck = false;
  bool interrupt = false;
  std::string also;
  bool wall_clock = false;
};

class Probe {
 public:
  Probe(Process& process, const ProbeOptions& options)
      : process_(process), options_(options), file_(options.read) {
    if (!options_.also.empty()) process.open_bus(options_.also);
    if (options_.interrupt) process.loop().call_at(process.now(), [] { raise(SIGINT); });
    if (options_.stuck) {
      process.loop().call_every(1'000, [this] {
        process_.status().set_phase("stuck");
        for (;;) pause();
      });
      return;
    }
    if (options_.write > 0) {
      process.loop().call_every(options_.period_ms * Utime{1000}, [this] { write_next(); });
      return;
    }
    process.bus().subscribe(kKeyframe, [this](const keyframe_t& keyframe) {
      file_ << keyframe.segment << ' ' << keyframe.id << std::endl;
    });
    process.bus().subscribe(kTrajectory, [this](const trajectory_t& trajectory) {
      loop_weights_t answer{};
      answer.utime =
          options_.wall_clock ? std::chrono::system_clock::now().time_since_epoch().count() : process_.now();
      answer.round = trajectory.round;
      process_.bus().publish(kLoopWeights, answer);
    });
    process.loop().call_every(100'000, [this] {
      loop_t loop{};
      loop.utime = process_.now();
      loop.number = number_++;
      process_.bus().publish(kLoop, loop);
    });
  }

 private:
  void write_next() {
    if (number_ == options_.write) {
      process_.status().set_phase("idle");
      return;
    }
    keyframe_t keyframe{};
    keyframe.utime = process_.now();
    keyframe.segment = options_.segment;
    keyframe.id = number_++;
    process_.bus().publish(kKeyframe, keyframe);
  }

  Process& process_;
  ProbeOptions options_;
  std::ofstream file_;
  std::int32_t number_ = 0;
};

}  // namespace
}  // namespace covey

int main(int argc, char** argv) {
  covey::ProbeOptions options;
  const auto add_options = [&options](CLI::App& app) {
    app.add_option("--write", options.write, "keyframes to write");
    app.add_option("--period-ms", options.period_ms, "between two of them");
    app.add_option("--segment", options.segment, "their segment");
    app.add_flag("--stuck", options.stuck, "stay in a handler for ever");
    app.add_flag("--interrupt", options.interrupt, "send itself SIGINT when its clock runs");
    app.add_option("--also", options.also, "URL of a second bus");
    app.add_flag("--wall-clock", options.wall_clock, "what no process may do: an output that depends on it");
    app.add_option("--read", options.read, "file for the keyframes that arrive");
  };
  return covey::run_process(
      argc, argv, {.name = "probe", .summary = "test of procs/common", .add_options = add_options},
      [&](covey::Process& process) { return std::make_unique<covey::Probe>(process, options); });
}
