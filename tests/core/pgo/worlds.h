// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Pose graphs made up for tests: a walk over a grid with noisy odometry, and a loop wherever it comes near an
// earlier pose.

#include <cmath>
#include <numbers>
#include <random>

#include "core/pgo/pose_graph.h"

namespace covey::pgo {

struct WalkOptions {
  int dimension = 3;
  int poses = 200;
  double rotation_sigma = 0.01;     // rad, per edge
  double translation_sigma = 0.05;  // m, per edge
  int grid = 6;                     // m; the walk turns at the borders of a square (cube) of this size
  int seed = 1;
};

struct Walk {
  PoseGraph graph;  // of one robot
  Poses truth;      // starts at identity
};

inline Walk make_walk(const WalkOptions& options) {
  std::mt19937_64 random(options.seed);
  std::normal_distribution<double> normal;
  const int d = options.dimension;
  const auto noise = [&](double sigma) { return sigma * normal(random); };
  const auto perturb = [&](const SE3& T) {
    const Eigen::Vector3d phi(d == 3 ? noise(options.rotation_sigma) : 0.0,
                              d == 3 ? noise(options.rotation_sigma) : 0.0, noise(options.rotation_sigma));
    const Eigen::Vector3d rho(noise(options.translation_sigma), noise(options.translation_sigma),
                              d == 3 ? noise(options.translation_sigma) : 0.0);
    return SE3{T.rotation * SO3::exp(phi), T.translation + rho};
  };
  Walk walk;
  walk.graph = {d, {options.poses}, {}};
  walk.truth.emplace_back();
  const auto inside = [&](const Eigen::Vector3d& p) {
    return (p.array() > -0.5 && p.array() < options.grid - 0.5).all();
  };
  while (static_cast<int>(walk.truth.size()) < options.poses) {
    const int axis = d == 2 ? 2 : static_cast<int>(random() % 3);
    const double angle = 0.5 * std::numbers::pi * (static_cast<int>(random() % 3) - 1);
    const SO3 turn = SO3::exp(angle * Eigen::Vector3d::Unit(axis));
    const SE3 next = walk.truth.back() * SE3{turn, turn * Eigen::Vector3d::UnitX()};
    if (inside(next.translation)) walk.truth.push_back(next);
  }
  const double kappa = 0.5 / (options.rotation_sigma * options.rotation_sigma) * (d == 2 ? 2.0 : 1.0);
  const double tau = 1.0 / (options.translation_sigma * options.translation_sigma);
  const auto measure = [&](int i, int j, EdgeKind kind) {
    const SE3 measured = perturb(walk.truth[i].inverse() * walk.truth[j]);
    walk.graph.edges.push_back({{0, i}, {0, j}, measured, kappa, tau, kind, kind == EdgeKind::kOdometry});
  };
  for (int i = 0; i + 1 < options.poses; ++i) measure(i, i + 1, EdgeKind::kOdometry);
  for (int j = 0; j < options.poses; ++j) {
    for (int i = 0; i + 1 < j; ++i) {
      if ((walk.truth[i].translation - walk.truth[j].translation).norm() < 0.5 && random() % 2 == 0) {
        measure(i, j, EdgeKind::kLoop);
      }
    }
  }
  return walk;
}

}  // namespace covey::pgo
