// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The solvers that pgo knows by name.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey {

struct SolverOptions {
  std::string name;
  double barc2 = 0.0;             // truncation of robust solvers
  std::uint64_t seed = 1;         // of what a solver draws
  std::optional<double> optimum;  // stop where cost <= optimum (1 + gap)
  std::optional<double> gap;
};

struct Solution {
  pgo::Poses poses;
  int iterations = 0;
  bool converged = false;
  std::optional<std::int64_t> block_updates;  // the distributed solvers have these
  std::optional<std::int64_t> rounds;
  std::optional<std::int64_t> bytes_sent;
};

struct Solver {
  std::string name;
  std::string summary;
  bool robust = false;  // minimises the robust cost, else least squares
  Solution (*solve)(const pgo::PoseGraph& graph, const SolverOptions& options) = nullptr;
};

const std::vector<Solver>& all_solvers();

}  // namespace covey
