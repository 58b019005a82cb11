// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lcd/node.h"

int main(int argc, char** argv) {
  return covey::run_process(
      argc, argv,
      {.name = "lcd",
       .summary =
           "loop closures: finds where a robot, or two, saw the same place, and measures how they stood",
       .reads_sensors = true},
      [](covey::Process& process) { return std::make_shared<covey::LcdNode>(process); });
}
