// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/consistency.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace covey {
namespace {

// Keyframes of a robot that drives in a circle, and odometry whose steps are off by what their covariance says.
struct Walk {
  Trajectory truth;
  std::vector<EdgeBelief> edges;
  std::vector<PoseBelief> states;  // the edges, chained
};

Walk walk(int seed, int steps) {
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  std::normal_distribution<double> normal;
  Matrix6d P = Matrix6d::Zero();
  P.diagonal() << 1e-4, 4e-4, 1e-4, 1e-6, 1e-6, 4e-6;
  const SE3 step{SO3::exp({0.0, 0.02, 0.1}), {0.5, 0.0, 0.02}};
  Walk walk;
  SE3 T_W_B{SO3::exp({0.0, 0.0, 1.0}), {3.0, 4.0, 5.0}};
  const SE3 T_O_W = SE3{SO3::exp({0.0, 0.0, -0.7}), {1.0, 2.0, 3.0}};
  SE3 T_O_B = T_O_W * T_W_B;
  Matrix6d covariance = Matrix6d::Zero();
  const Utime segment = kUsPerSecond;
  for (int k = 0; k <= steps; ++k) {
    const Utime utime = segment + 500'000 * k;
    walk.truth.push_back({utime, T_W_B});
    walk.states.push_back({utime, segment, T_O_B, covariance});
    Vector6d noise;
    for (int i = 0; i < 6; ++i) noise[i] = std::sqrt(P(i, i)) * normal(random);
    const SE3 measured = step * SE3::exp(-noise);
    if (k == 0) walk.edges.push_back({utime, segment, 0, SE3{}, Matrix6d::Zero()});
    walk.edges.push_back({utime + 500'000, segment, k + 1, measured, P});
    T_W_B = T_W_B * step;
    T_O_B = T_O_B * measured;
    const Matrix6d Ad = measured.inverse().adjoint();
    covariance = Ad * covariance * Ad.transpose() + P;
  }
  walk.truth.push_back({segment + 500'000 * (steps + 1), T_W_B});
  return walk;
}

TEST_CASE("errors that are drawn from the covariance have a NEES of one, over states and over edges") {
  double states = 0.0;
  double edges = 0.0;
  constexpr int kRuns = 200;
  for (int seed = 0; seed < kRuns; ++seed) {
    const Walk one = walk(seed, 60);
    const Nees of_states = state_nees(one.states, one.truth);
    CHECK(of_states.count == 60);
    states += of_states.mean / kRuns;
    const Nees of_edges = edge_nees(one.edges, one.truth, 5.0);
    CHECK(of_edges.count == 6);
    edges += of_edges.mean / kRuns;
  }
  CHECK(states == Approx(1.0).margin(0.15));
  CHECK(edges == Approx(1.0).margin(0.08));
}

TEST_CASE("who is too sure of itself by a factor of two in sigma has a NEES of four") {
  double mean = 0.0;
  for (int seed = 0; seed < 100; ++seed) {
    Walk one = walk(seed, 20);
    for (EdgeBelief& edge : one.edges) edge.covariance *= 0.25;
    mean += edge_nees(one.edges, one.truth, 1.0).mean / 100.0;
  }
  CHECK(mean == Approx(4.0).epsilon(0.1));
}

TEST_CASE("chains do not cross segments or gaps, and what the reference does not cover is left out") {
  Walk one = walk(1, 20);
  CHECK(edge_nees(one.edges, one.truth, 20.0).count == 0);
  CHECK(edge_nees(one.edges, one.truth, 5.0).count == 2);
  one.edges.erase(one.edges.begin() + 11);
  CHECK(edge_nees(one.edges, one.truth, 5.0).count == 1);
  CHECK(state_nees(one.states, Trajectory(one.truth.begin() + 5, one.truth.begin() + 9)).count == 3);
}

}  // namespace
}  // namespace covey
