// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>

#include "procs/common/tool.h"
#include "procs/sim/simulate.h"

int main(int argc, char** argv) {
  CLI::App app("simulated worlds, from nothing but a seed", "sim");
  covey::SimOptions options;
  covey::add_sim_options(app, options);
  return covey::run_tool(argc, argv, app, [&options] {
    covey::simulate(options);
    return 0;
  });
}
