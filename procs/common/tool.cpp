// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/tool.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "core/base/error.h"

namespace covey {

int run_tool(int argc, char** argv, CLI::App& app, const std::function<int()>& work) {
  try {
    app.parse(argc, argv);
    return work();
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    fmt::print(stderr, "{}: {}\n", app.get_name(), error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", app.get_name(), error.what());
    return 1;
  }
}

}  // namespace covey
