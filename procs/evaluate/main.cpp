// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/base/error.h"
#include "procs/evaluate/commands.h"

int main(int argc, char** argv) {
  CLI::App app("how good a result is, as JSON on stdout", "evaluate");
  app.require_subcommand(1);
  covey::add_trajectory_command(app);
  covey::add_online_command(app);
  covey::add_graph_command(app);
  covey::add_radio_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const covey::InputError& error) {
    std::fprintf(stderr, "evaluate: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "evaluate: %s\n", error.what());
    return 1;
  }
  return 0;
}
