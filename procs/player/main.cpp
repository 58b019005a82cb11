// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/command_line.h"
#include "procs/common/process.h"
#include "procs/player/options.h"

int main(int argc, char** argv) {
  covey::PlayerOptions options;
  const covey::ProcessOptions process_options{
      .name = "player",
      .summary =
          "plays recorded data onto a bus: sensors in EuRoC's layout, depth images with poses, an LCM log, "
          "or a pose graph as a "
          "robot's front end would say it",
      .reads_depth = true,
      .serves_robot = false,
      .add_options = [&options](CLI::App& app) { covey::add_player_options(app, options); },
      .without_bus =
          [&options](const covey::CommandLine& command) {
            covey::convert(options, command.config, command.out);
          }};
  return covey::run_process(argc, argv, process_options, [&options](covey::Process& process) {
    return covey::make_player(process, options);
  });
}
