// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Absolute trajectory error (ATE): the distances between the positions of an estimate and of a reference at
// the same stamps, after the rigid motion that brings them closest together (alignment.h). A team shares one
// motion: robots that are each good by themselves and wrongly placed to each other are wrong. Source: Sturm
// et al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012.

#include <vector>

#include "core/geometry/trajectory.h"

namespace covey {

struct AteOptions {
  double max_stamp_difference_s = 0.01;  // further apart is not the same moment
};

// The distances in m, over the poses that were matched.
struct TrajectoryError {
  int estimate_poses = 0;
  int reference_poses = 0;
  int matched = 0;  // zero: nothing was compared, and the figures below mean nothing
  double rmse_m = 0.0;
  double mean_m = 0.0;
  double median_m = 0.0;
  double max_m = 0.0;
  SE3 T_reference_estimate;
};

struct TrajectoryPair {
  Trajectory estimate;
  Trajectory reference;
};

struct TeamError {
  TrajectoryError team;                    // one motion for all robots
  std::vector<TrajectoryError> with_team;  // each robot's share under that motion
  std::vector<TrajectoryError> by_itself;  // each robot under a motion of its own
};

// Pairs (index in a, index in b) of nearest stamps, each pose used once, in order of time.
std::vector<std::pair<int, int>> match_stamps(const Trajectory& a, const Trajectory& b,
                                              double max_difference_s);

TrajectoryError trajectory_error(const TrajectoryPair& pair, const AteOptions& options = {});
TeamError team_error(const std::vector<TrajectoryPair>& robots, const AteOptions& options = {});

}  // namespace covey
