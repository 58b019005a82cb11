// SPDX-License-Identifier: BSD-3-Clause
#include "procs/radio_bridge/node.h"

int main(int argc, char** argv) {
  covey::RadioDoor door;
  return covey::run_process(
      argc, argv,
      {.name = "radio_bridge",
       .summary = "carries messages between a robot's bus and the radio",
       .add_options = [&door](CLI::App& app) { covey::add_command_line(app, door.options); },
       .before_bus = [&door](covey::Process& process) { door.open(process); }},
      [&door](covey::Process& process) { return std::make_shared<covey::RadioBridgeNode>(process, door); });
}
