// SPDX-License-Identifier: BSD-3-Clause
#include "procs/pgo/solvers.h"

namespace covey {

const std::vector<Solver>& all_solvers() {
  static const std::vector<Solver> kSolvers = [] {
    std::vector<Solver> all;
    for (const auto& family :
         {central_solvers(), rbcd_solvers(), schur_solvers(), dgnc_solvers(), elected_solvers()})
      all.insert(all.end(), family.begin(), family.end());
    return all;
  }();
  return kSolvers;
}

}  // namespace covey
