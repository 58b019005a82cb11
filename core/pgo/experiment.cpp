// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/experiment.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <utility>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

PoseId pose_at(const std::vector<int>& offsets, int flat) {
  const auto robot = std::upper_bound(offsets.begin(), offsets.end(), flat) - offsets.begin() - 1;
  return {static_cast<int>(robot), flat - offsets[robot]};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

SE3 random_motion(std::mt19937_64& random, int dimension) {
  std::uniform_real_distribution<double> coordinate(-10.0, 10.0);
  SE3 T;
  if (dimension == 2) {
    std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
    T.rotation = SO3::exp({0.0, 0.0, angle(random)});
  } else {
    std::normal_distribution<double> normal;
    Eigen::Vector4d q;
    for (double& value : q) value = normal(random);
    T.rotation = SO3::from_quaternion(Eigen::Quaterniond(q));
  }
  for (int axis = 0; axis < dimension; ++axis) T.translation[axis] = coordinate(random);
  return T;
}

}  // namespace

PoseGraph cut_into_robots(const PoseGraph& graph, int robots) {
  COVEY_CHECK(graph.robots() == 1 && robots >= 1 && robots <= graph.poses());
  const std::int64_t n = graph.poses();
  std::vector<int> offsets;
  for (std::int64_t r = 0; r <= robots; ++r) offsets.push_back(static_cast<int>(r * n / robots));
  PoseGraph cut{graph.dimension, {}, graph.edges};
  for (int r = 0; r < robots; ++r) cut.poses_per_robot.push_back(offsets[r + 1] - offsets[r]);
  for (Edge& edge : cut.edges) {
    edge.from = pose_at(offsets, edge.from.index);
    edge.to = pose_at(offsets, edge.to.index);
    if (edge.between_robots()) {
      edge.kind = EdgeKind::kLoop;
      edge.known_inlier = false;
    }
  }
  return cut;
}

Injection inject_outliers(const PoseGraph& graph, double share, std::uint64_t seed) {
  COVEY_CHECK(share >= 0.0 && share < 1.0);
  Injection result{graph, std::vector<bool>(graph.edges.size(), true)};
  const int loops = graph.loops();
  const auto wanted = std::lround(loops * share / (1.0 - share));
  if (wanted == 0) return result;
  std::vector<double> kappas;
  std::vector<double> taus;
  for (const Edge& edge : graph.edges) {
    if (loops > 0 && edge.kind != EdgeKind::kLoop) continue;
    kappas.push_back(edge.kappa);
    taus.push_back(edge.tau);
  }
  const double kappa = median(std::move(kappas));
  const double tau = median(std::move(taus));
  const std::vector<int> offsets = graph.offsets();
  const int n = graph.poses();
  const int with_poses = static_cast<int>(
      std::count_if(graph.poses_per_robot.begin(), graph.poses_per_robot.end(), [](int p) { return p > 0; }));
  COVEY_CHECK(with_poses > 1 || n > 2);
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> any(0, n - 1);
  for (long k = 0; k < wanted; ++k) {
    Edge edge;
    int from = 0;
    int to = 0;
    do {
      from = any(random);
      to = any(random);
      edge.from = pose_at(offsets, from);
      edge.to = pose_at(offsets, to);
    } while (with_poses > 1 ? !edge.between_robots() : std::abs(from - to) <= 1);
    edge.measurement = random_motion(random, graph.dimension);
    edge.kappa = kappa;
    edge.tau = tau;
    result.graph.edges.push_back(edge);
    result.is_true.push_back(false);
  }
  return result;
}

}  // namespace covey::pgo
