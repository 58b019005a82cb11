// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/node.h"

int main(int argc, char** argv) {
  return covey::run_process(
      argc, argv,
      {.name = "vio",
       .summary = "visual-inertial odometry: IMU and stereo pictures, or somebody else's odometry, to STATE "
                  "and KEYFRAME",
       .reads_sensors = true},
      [](covey::Process& process) { return std::make_shared<covey::VioNode>(process); });
}
