// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A small pose graph with known truth: a ring of poses with noisy odometry and chords across it.

#include "core/graph/graph.h"
#include "core/graph/pose_factors.h"
#include "tests/core/geometry/random.h"

namespace covey::graph::testing {

inline Key pose_key(int k) { return {'x', static_cast<std::uint64_t>(k)}; }

struct RingWorld {
  static constexpr int kPoses = 40;
  static constexpr double kKappa = 1e4;
  static constexpr double kTau = 1e2;

  Graph graph;
  Values start;                 // odometry, chained
  std::vector<SE3> truth;       // truth[0] is the constant pose
  std::vector<FactorId> loops;  // true ones first
  int true_loops = 0;
};

inline SE3 measure(const SE3& T_i_j, covey::testing::RandomGeometry& random) {
  Vector6d xi;
  xi << random.vector<3>(1.0 / std::sqrt(RingWorld::kTau)),
      random.vector<3>(1.0 / std::sqrt(2.0 * RingWorld::kKappa));
  return T_i_j * SE3::exp(xi);
}

inline RingWorld make_ring(int false_loops, std::uint64_t seed = 1) {
  covey::testing::RandomGeometry random(seed);
  RingWorld world;
  for (int k = 0; k < RingWorld::kPoses; ++k) {
    const double angle = 4.0 * std::numbers::pi * k / RingWorld::kPoses;  // two rounds
    world.truth.push_back({SO3::exp({0.1 * random.normal(), 0.1 * random.normal(), angle}),
                           {10.0 * std::cos(angle), 10.0 * std::sin(angle), 0.05 * k}});
  }
  const auto add = [&](int i, int j, const SE3& measured) {
    return world.graph.add(ChordalBetween3{measured, RingWorld::kKappa, RingWorld::kTau},
                           {pose_key(i), pose_key(j)});
  };
  SE3 chained = world.truth[0];
  world.start.set(pose_key(0), chained);
  for (int k = 1; k < RingWorld::kPoses; ++k) {
    const SE3 odometry = measure(world.truth[k - 1].inverse() * world.truth[k], random);
    add(k - 1, k, odometry);
    chained = chained * odometry;
    world.start.set(pose_key(k), chained);
  }
  for (int k = 0; k < RingWorld::kPoses / 2; ++k) {
    const int other = k + RingWorld::kPoses / 2;
    world.loops.push_back(add(k, other, measure(world.truth[k].inverse() * world.truth[other], random)));
  }
  world.true_loops = static_cast<int>(world.loops.size());
  for (int n = 0; n < false_loops; ++n) {
    const int i = random.index(RingWorld::kPoses - 2);
    const int j = i + 2 + random.index(RingWorld::kPoses - i - 2);
    const Eigen::Vector3d t(random.uniform(-10, 10), random.uniform(-10, 10), random.uniform(-10, 10));
    world.loops.push_back(add(i, j, {random.rotation(), t}));
  }
  world.graph.set_constant(pose_key(0));
  return world;
}

inline double worst_translation_error(const Values& values, const std::vector<SE3>& truth) {
  double worst = 0.0;
  for (int k = 0; k < static_cast<int>(truth.size()); ++k) {
    worst = std::max(worst, (values.get<SE3>(pose_key(k)).translation - truth[k].translation).norm());
  }
  return worst;
}

}  // namespace covey::graph::testing
