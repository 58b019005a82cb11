// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/CLI.hpp>
#include <cstdio>

#include "core/base/error.h"
#include "procs/sim/simulate.h"

int main(int argc, char** argv) {
  CLI::App app("simulated worlds, from nothing but a seed", "sim");
  covey::SimOptions options;
  covey::add_sim_options(app, options);
  try {
    app.parse(argc, argv);
    covey::simulate(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const covey::InputError& error) {
    std::fprintf(stderr, "sim: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "sim: %s\n", error.what());
    return 1;
  }
  return 0;
}
