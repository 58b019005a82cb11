// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "procs/common/tool.h"
#include "procs/evaluate/commands.h"

int main(int argc, char** argv) {
  CLI::App app("how good a result is, as JSON on stdout", "evaluate");
  app.require_subcommand(1);
  covey::add_trajectory_command(app);
  covey::add_odometry_command(app);
  covey::add_online_command(app);
  covey::add_graph_command(app);
  covey::add_mesh_command(app);
  covey::add_radio_command(app);
  return covey::run_tool(argc, argv, app, [] { return 0; });
}
