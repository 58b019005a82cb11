// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/command_line.h"

#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/base/error.h"

namespace covey {
std::optional<CommandLine> parse_command_line(int argc, char** argv, const ProcessOptions& options) {
  CommandLine command;
  command.name = options.name;
  std::string faults;
  CLI::App app(options.summary, options.name);
  auto* robot = app.add_option("--robot", command.robot, "id of the robot that this process serves")
                    ->check(CLI::Range(0, kLastRobot));
  if (options.serves_robot) robot->required();
  app.add_option("--config", command.config, "YAML file; an unknown key is an error");
  app.add_option(
      "--url", command.url,
      "LCM bus, or file://F.lcm to run from a log (default: the robot's private bus, port 7700 + robot)");
  if (options.reads_sensors) {
    app.add_option(
        "--sensor-url", command.sensor_url,
        "bus of the robot's IMU and stereo images (default: port 7720 + robot; from a log, that log)");
  }
  if (options.reads_depth) {
    app.add_option("--depth-url", command.depth_url,
                   "bus of the robot's depth images (default: port 7740 + robot; from a log, that log)");
  }
  app.add_option("--state", command.state_dir, "folder for what must survive a restart; created if absent");
  app.add_option("--out", command.out, "record what is published to this LCM log");
  app.add_option("--tum", command.tum_path, "write the trajectory to this file (TUM format) at the end");
  app.add_option("--bus-faults", faults,
                 "make reception worse, for tests: drop=0.1,duplicate=0.05,delay_ms=50,seed=1");
  app.set_version_flag("--version", options.name + " (covey) " COVEY_VERSION);
  if (options.add_options) options.add_options(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    app.exit(help_or_version);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw InputError(std::string(error.what()) + "; --help lists the options");
  }
  command.faults = parse_bus_faults(faults);
  const bool without_bus = command.robot < 0 && options.without_bus && !command.out.empty();
  if (command.url.empty() && !without_bus) {
    if (command.robot < 0) throw_input_error("--url is needed where --robot is not given");
    command.url = robot_bus_url(command.robot);
  }
  if (command.robot >= 0 && !is_log_url(command.url)) {
    if (command.sensor_url.empty()) command.sensor_url = sensor_bus_url(command.robot);
    if (command.depth_url.empty()) command.depth_url = depth_bus_url(command.robot);
  }
  if (!command.state_dir.empty()) {
    std::error_code error;
    std::filesystem::create_directories(command.state_dir, error);
    if (error) throw_input_error("--state {}: {}", command.state_dir.string(), error.message());
  }
  return command;
}

}  // namespace covey
