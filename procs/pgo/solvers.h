// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The solvers that pgo knows by name.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/pgo/pose_graph.h"
#include "core/pgo/rbcd.h"

namespace covey {

struct SolverOptions {
  std::string name;
  double barc2 = 0.0;             // truncation of robust solvers
  std::uint64_t seed = 1;         // of what a solver draws
  std::string start;              // robust, chordal or odometry; empty: the solver's own
  std::optional<double> optimum;  // stop where cost <= optimum (1 + gap)
  std::optional<double> gap;
  double mu_step = 0.0;                                  // of dgnc; 0: its adaptive schedule
  pgo::Schedule schedule = pgo::RbcdOptions{}.schedule;  // of rbcd
};

struct Solution {
  pgo::Poses poses;
  int iterations = 0;
  std::optional<bool> converged;  // nothing where the solver stops by a schedule
  std::vector<double> weights;    // per edge, of the problem that was solved last; empty for all 1
  std::vector<bool> kept;         // per edge; empty where what is kept is what has r^2 <= barc2
  // Of distributed solvers.
  struct Team {
    std::int64_t block_updates = 0;  // one robot solving its own poses once
    std::int64_t rounds = 0;         // in which every robot updates once
    std::int64_t bytes_sent = 0;     // messages as encoded, a broadcast counted once
    double watch_seconds = 0.0;      // CPU spent on comparing with the optimum, which is not the robots' work
  };
  std::optional<Team> team;
};

struct Solver {
  std::string name;
  std::string summary;
  bool robust = false;  // minimises the robust cost, else least squares
  Solution (*solve)(const pgo::PoseGraph& graph, const SolverOptions& options) = nullptr;
  bool any_start = false;  // it begins where SolverOptions::start says
};

// One family to a file, <family>_solvers.cpp; all of them in the order of --help.
std::vector<Solver> central_solvers();
std::vector<Solver> rbcd_solvers();
std::vector<Solver> schur_solvers();
std::vector<Solver> dgnc_solvers();
std::vector<Solver> elected_solvers();
const std::vector<Solver>& all_solvers();

}  // namespace covey
