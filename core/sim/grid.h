// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The pose-graph world `grid`: robots drive through the streets of a town of square blocks on gently rolling
// ground, one keyframe a second. What a front end would report of that is drawn directly: odometry with noise
// between successive keyframes, closures with noise between keyframes that see the same place the same way,
// and false closures between any two, with uniform rotation and each coordinate within +-10 m.
//
// Noise of a measured T_A_B is T_true * Exp([rho; phi]) with isotropic sigmas, and the edges carry the
// matching kappa = 1 / (2 sigma_R^2), tau = 1 / sigma_t^2, so that squared residuals of right edges at the
// truth are chi-square with 6 degrees of freedom. A false closure carries the same precisions as a right one:
// nothing gives it away.

#include <cstdint>
#include <vector>

#include "core/base/config.h"
#include "core/geometry/trajectory.h"
#include "core/pgo/pose_graph.h"

namespace covey::sim {

struct GridOptions {
  int robots = 3;
  int keyframes = 120;  // per robot, one a second
  std::uint64_t seed = 1;

  int blocks = 0;             // along each side of the town; 0: as many as suit the length of the drive
  double block_m = 8.0;       // length of a side of a block
  double step_m = 1.6;        // between keyframes; block_m is a multiple of it
  double undulation_m = 0.6;  // amplitude of the ground's height

  double odometry_rotation_sigma_deg = 0.6;
  double odometry_translation_sigma_m = 0.04;
  double closure_rotation_sigma_deg = 1.0;
  double closure_translation_sigma_m = 0.08;

  double closure_range_m = 1.7;      // between keyframes that see the same place
  double closure_angle_deg = 45.0;   // between their headings
  int closure_min_separation = 15;   // keyframes, for closures of a robot with itself
  double closure_probability = 0.5;  // that a keyframe closes with a given robot's nearest earlier pass
  double false_share = 1.0 / 3.0;    // of all closures
  int min_links = 6;
};

// Overwrites what the section has; robots, keyframes and seed come from the command line.
void read_grid(ConfigSection& section, GridOptions& options);

struct GridWorld {
  pgo::PoseGraph graph;     // odometry first, robot after robot; then closures, as if found in order of time
  std::vector<bool> right;  // per edge
  std::vector<Trajectory> truth;  // per robot, in the frame of the town
};

// The same options give the same world. Drives are redrawn until every robot is linked to the others, along
// some chain of pairs, by at least `min_links` right closures for each pair; InputError where a hundred
// drives do not get there.
GridWorld make_grid(const GridOptions& options);

}  // namespace covey::sim
