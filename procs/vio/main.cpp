// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <filesystem>

#include "procs/vio/node.h"

int main(int argc, char** argv) {
  std::filesystem::path frames;
  return covey::run_process(
      argc, argv,
      {.name = "vio",
       .summary = "visual-inertial odometry: IMU and stereo pictures, or somebody else's odometry, to STATE "
                  "and KEYFRAME",
       .reads_sensors = true,
       .add_options =
           [&frames](CLI::App& app) {
             app.add_option("--frames", frames, "CSV: what every picture set cost and what became of it");
           }},
      [&frames](covey::Process& process) { return std::make_shared<covey::VioNode>(process, frames); });
}
