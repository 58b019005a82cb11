// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pose_graph.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/error.h"

namespace covey::pgo {

int PoseGraph::poses() const { return std::accumulate(poses_per_robot.begin(), poses_per_robot.end(), 0); }

int PoseGraph::loops() const {
  return static_cast<int>(std::count_if(edges.begin(), edges.end(),
                                        [](const Edge& edge) { return edge.kind == EdgeKind::kLoop; }));
}

std::vector<int> PoseGraph::offsets() const {
  std::vector<int> offsets(poses_per_robot.size() + 1, 0);
  std::partial_sum(poses_per_robot.begin(), poses_per_robot.end(), offsets.begin() + 1);
  return offsets;
}

namespace {

int find_root(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

}  // namespace

std::vector<int> connected_parts(const PoseGraph& graph) {
  const std::vector<int> offsets = graph.offsets();
  std::vector<int> parent(graph.poses());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Edge& edge : graph.edges) {
    const int a = find_root(parent, offsets[edge.from.robot] + edge.from.index);
    const int b = find_root(parent, offsets[edge.to.robot] + edge.to.index);
    parent[std::max(a, b)] = std::min(a, b);
  }
  std::vector<int> part(parent.size());
  int parts = 0;
  for (int i = 0; i < static_cast<int>(parent.size()); ++i) {
    const int root = find_root(parent, i);  // the smallest of its part, hence numbered already unless it is i
    part[i] = root == i ? parts++ : part[root];
  }
  return part;
}

PoseGraph as_one_robot(const PoseGraph& graph) {
  const std::vector<int> offsets = graph.offsets();
  PoseGraph one{graph.dimension, {graph.poses()}, graph.edges};
  for (Edge& edge : one.edges) {
    edge.from = {0, offsets[edge.from.robot] + edge.from.index};
    edge.to = {0, offsets[edge.to.robot] + edge.to.index};
  }
  return one;
}

Restriction keep_robots_with_odometry(const PoseGraph& graph) {
  std::vector<bool> keep(graph.robots());
  for (int robot = 0; robot < graph.robots(); ++robot) keep[robot] = graph.poses_per_robot[robot] == 1;
  for (const Edge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kOdometry) keep[edge.from.robot] = true;
  }
  Restriction result{{graph.dimension, graph.poses_per_robot, {}}, 0};
  for (int robot = 0; robot < graph.robots(); ++robot) {
    if (!keep[robot]) result.graph.poses_per_robot[robot] = 0;
  }
  for (const Edge& edge : graph.edges) {
    if (keep[edge.from.robot] && keep[edge.to.robot]) {
      result.graph.edges.push_back(edge);
    } else {
      ++result.dropped_edges;
    }
  }
  return result;
}

PoseGraph robust_form(PoseGraph graph) {
  if (graph.dimension == 2) {
    for (Edge& edge : graph.edges) edge.kappa *= 0.5;
  }
  return graph;
}

Eigen::MatrixXd rotation_of(const SE3& T, int dimension) {
  return T.rotation.matrix().topLeftCorner(dimension, dimension);
}

Eigen::VectorXd translation_of(const SE3& T, int dimension) { return T.translation.head(dimension); }

SE3 pose_of(const Eigen::MatrixXd& rotation, const Eigen::VectorXd& translation) {
  COVEY_CHECK(rotation.rows() == rotation.cols() && rotation.rows() == translation.size());
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  R.topLeftCorner(rotation.rows(), rotation.cols()) = rotation;
  SE3 T;
  T.rotation = SO3::from_matrix(R);
  T.translation.head(translation.size()) = translation;
  return T;
}

}  // namespace covey::pgo
