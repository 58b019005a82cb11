// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A tool runs once, on files, without a bus: from its command line to the exit code that all of Covey has. 0 done, 1 failed, 2 bad
// usage or input, with one sentence on stderr.

#include <functional>

namespace CLI {
class App;
}

namespace covey {

// Parses with `app`, whose subcommands may run as callbacks, then does `work`, which returns the exit code.
int run_tool(int argc, char** argv, CLI::App& app, const std::function<int()>& work);

}  // namespace covey
