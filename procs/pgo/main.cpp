// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "procs/common/tool.h"
#include "procs/pgo/command.h"

int main(int argc, char** argv) {
  CLI::App app("solves a pose graph, centrally or as a team of robots, and says how well", "pgo");
  covey::PgoCommand command;
  command.add_options(app);
  return covey::run_tool(argc, argv, app, [&command] { return command.run(); });
}
