// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Makes multi-robot and outlier experiments, by definitions that tables can be compared with: from one robot's graph by
// cutting it and adding wrong loops, or from nothing (stata_like).

#include <cstdint>
#include <vector>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

// Cuts a graph of one robot into `robots` contiguous ranges of poses, equal up to one pose: robot r has the
// poses from floor(r n / N) to floor((r + 1) n / N). Flat indices stay. Odometry across a cut becomes a loop
// between robots, and no known inlier. 1 <= robots <= poses.
PoseGraph cut_into_robots(const PoseGraph& graph, int robots);

// Adds round(n_loops share / (1 - share)) random loops, so that `share` (0 <= share < 1) of all loops are
// wrong: between random poses of different robots (with one robot: between any two that do not follow each
// other), rotation uniform, each coordinate of the translation uniform in [-10, 10] m, with the median kappa
// and tau of the loops that are there (of all edges when there are none). The same seed gives the same loops.
struct Injection {
  PoseGraph graph;            // the new loops stand last
  std::vector<bool> is_true;  // per edge
};
Injection inject_outliers(const PoseGraph& graph, double share, std::uint64_t seed);

// Robots that walk the corridors of one large building again and again and hardly ever recognise each other's places: what
// the paper met in the Stata Center (three robots, some 3700 keyframes each; one pair had a single right closure, which its
// solver lost with default settings). Corridors are a grid of blocks; at a crossing a robot goes any way but back, turning on
// the spot. Noise of a measured T_i_j is T * Exp([rho; phi]) with isotropic sigmas and the edges carry the matching kappa and
// tau, so that r^2 of a true edge at the truth is chi-square with 6 degrees of freedom. Closures of a robot with itself join
// poses within `range` and 45 deg of heading that lie at least 50 poses apart; of all of them, wrong ones included,
// `false_share` are wrong: between random poses that do not follow each other, uniform rotation, each coordinate of the
// translation uniform in [-10, 10] m, the same kappa and tau as the true ones. The closures between two robots are all true.
struct StataOptions {
  int poses_per_robot = 3700;  // at least 500
  int blocks_x = 4;
  int blocks_y = 3;
  double block = 15.0;                        // m, side of a block
  double step = 0.5;                          // m between poses, +-10 %
  double odometry_rotation_sigma = 0.002;     // rad, per step
  double odometry_translation_sigma = 0.015;  // m, per step
  double closure_rotation_sigma = 0.01;
  double closure_translation_sigma = 0.05;
  double range = 1.0;            // m
  int closures_per_robot = 300;  // true ones
  double false_share = 0.2;
  std::vector<int> between = {2, 1, 0};  // closures of the pairs (0, 1), (1, 2), (0, 2)
  std::uint64_t seed = 1;
};
struct StataWorld {
  PoseGraph
      graph;  // odometry first, robot after robot; then the robots' own loops; those between robots last
  std::vector<bool> is_true;  // per edge
  Poses truth;                // in the frame of the building
};
StataWorld stata_like(const StataOptions& options = {});

}  // namespace covey::pgo
