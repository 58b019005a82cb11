// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The command line of pgo: what to solve, how, and what to compare with. procs/pgo/README.md has the definitions.

#include <CLI/CLI.hpp>
#include <filesystem>

#include "procs/pgo/problem.h"
#include "procs/pgo/solvers.h"

namespace covey {

class PgoCommand {
 public:
  void add_options(CLI::App& app);

  // Returns the exit code: 0, or 1 when --gap was not reached. Throws InputError.
  int run();

 private:
  ProblemOptions problem_;
  SolverOptions solver_;
  double probability_ = 0.99;
  bool certify_ = false;
  bool decisions_ = false;
  std::filesystem::path json_;
  std::filesystem::path tum_;
};

}  // namespace covey
