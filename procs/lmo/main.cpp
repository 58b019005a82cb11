// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "procs/lmo/node.h"

int main(int argc, char** argv) {
  std::filesystem::path mesh_dir;
  return covey::run_process(
      argc, argv,
      {.name = "lmo",
       .summary = "local mesh optimisation: the robot's mesh follows its keyframes into the team's frame",
       .add_options =
           [&](CLI::App& app) {
             app.add_option("--mesh", mesh_dir,
                            "folder for robot<R>_vio.ply and robot<R>_team.ply; created if absent");
           }},
      [&](covey::Process& process) { return std::make_shared<covey::LmoNode>(process, mesh_dir); });
}
