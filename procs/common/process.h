// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What every process shares: command line, configuration, bus, loop, STATUS, clean end. A main is
//
//   int main(int argc, char** argv) {
//     return covey::run_process(argc, argv, {.name = "dpgo", .summary = "distributed pose-graph optimisation"},
//                               [](covey::Process& process) { return std::make_unique<covey::DpgoNode>(process); });
//   }
//
// and the node subscribes and sets timers in its constructor. procs/common/README.md shows a whole one.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "core/base/config.h"
#include "core/geometry/rig.h"
#include "procs/common/bus.h"
#include "procs/common/event_loop.h"
#include "procs/common/status.h"

namespace CLI {
class App;
}

namespace covey {

class Process;
struct CommandLine;

struct ProcessOptions {
  std::string name;
  std::string summary;         // one line for --help
  bool reads_sensors = false;  // --sensor-url, --depth-url: where sensor_bus() and depth_bus() are
  bool reads_depth = false;
  bool serves_robot = true;  // --robot must be given; else it may be, and robot() is -1 without it
  // Options of its own; include <CLI/CLI.hpp> in one file only.
  std::function<void(CLI::App&)> add_options = {};
  // What a process does when it is given --out but neither --url nor --robot: work on files, without a bus. May throw InputError.
  std::function<void(const CommandLine&)> without_bus = {};
  // What must happen before the bus is opened, such as entering a network namespace. There is no bus() yet.
  std::function<void(Process&)> before_bus = {};
};

class Process {
 public:
  struct Impl;
  explicit Process(std::unique_ptr<Impl> impl);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  const std::string& name() const;
  int robot() const;  // --robot
  Rig rig() const;  // the file that `sensors: FILE` in --config names, relative to it; InputError without one
  Config& config();  // --config; empty where not given. Keys that nobody reads are refused
  // A file that --config names, relative to it.
  std::filesystem::path beside_config(const std::string& file) const;
  const std::filesystem::path& state_dir() const;  // --state, created if absent; empty where not given
  const std::filesystem::path& tum_path() const;   // --tum; empty where not given
  bool from_log() const;

  Utime now() const;  // us; live the system clock, from a log event time: the only clock that nodes use
  Bus& bus();         // --url; the robot's private bus by default
  // The robot's sensors, opened when they are first asked for. From a log they are in that log unless --sensor-url or
  // --depth-url names another.
  Bus& sensor_bus();
  Bus& depth_bus();
  // Another bus beside it, or another log: events of all logs come in order of time.
  Bus& open_bus(const std::string& url);
  EventLoop& loop();
  Status& status();

  void on_stop(std::function<void()>
                   handler);  // before the buses close, while there is still time to write and to publish
  void stop(int exit_code = 0);

 private:
  friend int run_process(int argc, char** argv, const ProcessOptions& options,
                         const std::function<std::shared_ptr<void>(Process&)>& make_node);
  int run(const std::function<std::shared_ptr<void>(Process&)>& make_node);
  void publish_status();

  std::unique_ptr<Impl> impl_;
};

// Everything from the command line to the exit code: 0 done, 1 failed, 2 bad usage or input (one sentence on
// stderr).
int run_process(int argc, char** argv, const ProcessOptions& options,
                const std::function<std::shared_ptr<void>(Process&)>& make_node);

}  // namespace covey
