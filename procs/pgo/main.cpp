// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/base/error.h"
#include "procs/pgo/command.h"

int main(int argc, char** argv) {
  CLI::App app("solves a pose graph, centrally or as a team of robots, and says how well", "pgo");
  covey::PgoCommand command;
  command.add_options(app);
  try {
    app.parse(argc, argv);
    return command.run();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const covey::InputError& error) {
    std::fprintf(stderr, "pgo: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pgo: %s\n", error.what());
    return 1;
  }
}
