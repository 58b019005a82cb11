// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which loop closures of a pose graph a team kept, from the weights that its robots named for them. A weight
// comes with the two poses of its closure and with its residual, not with the measurement, and the order of
// the weights says nothing (robots sort by a hash). So where the same two poses were measured several times,
// residuals tell the measurements apart.

#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey {

struct SaidWeight {
  pgo::PoseId from;
  pgo::PoseId to;
  double weight = 0.0;       // [0, 1]
  double residual_sq = 0.0;  // as pgo::RobustCost has it, at the solution to which the weight belongs
};

// Per edge: true for odometry and for closures whose weight is above one half. residuals_sq: per edge, at the
// team's solution. Of the edges and weights between the same two poses those with the nearest residuals belong
// together, the nearest pair first. Closures without a weight were not kept.
std::vector<bool> kept_by_weights(const pgo::PoseGraph& graph, const std::vector<double>& residuals_sq,
                                  const std::vector<SaidWeight>& said);

}  // namespace covey
