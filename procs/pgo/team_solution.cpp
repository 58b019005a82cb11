// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/team_solution.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace covey {

Solution solve_as_team(const pgo::PoseGraph& graph, const pgo::DistributedOptions& options) {
  pgo::DistributedResult result = pgo::solve_distributed(graph, options);
  for (const std::string& warning : result.warnings) fmt::print(stderr, "pgo: {}\n", warning);
  Solution solution;
  solution.poses = std::move(result.poses);
  solution.iterations = result.updates;
  solution.weights = std::move(result.weights);
  solution.team = Solution::Team{result.block_updates, result.updates, 0, 0.0};
  for (const auto& [type, bytes] : result.bytes) solution.team->bytes_sent += bytes;
  return solution;
}

}  // namespace covey
