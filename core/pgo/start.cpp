// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/start.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/stiefel.h"

namespace covey::pgo {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

int find_root(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

// Solves A X = B for a sparse positive definite A given by its lower triangle.
Eigen::MatrixXd solve_positive_definite(int size, const std::vector<Eigen::Triplet<double>>& lower,
                                        const Eigen::MatrixXd& B) {
  Sparse A(size, size);
  A.setFromTriplets(lower.begin(), lower.end());
  const Eigen::SimplicialLDLT<Sparse> factor(A);
  COVEY_CHECK(factor.info() == Eigen::Success);
  return factor.solve(B);
}

// Minimises sum kappa |R_to - R_from R|_F^2 over d x d matrices with the first one held at identity. Each row
// of a rotation matrix is an unknown of its own: with x_i the transposed row, the residuals are x_to - R^T
// x_from.
std::vector<Eigen::MatrixXd> relaxed_rotations(const PoseGraph& graph) {
  const int d = graph.dimension;
  const std::vector<int> offsets = graph.offsets();
  const int unknowns = d * (graph.poses() - 1);
  std::vector<Eigen::Triplet<double>> lower;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(unknowns, d);
  const auto add_block = [&](int row, int column, const Eigen::MatrixXd& block) {
    for (int r = 0; r < d; ++r) {
      for (int c = 0; c < d; ++c) {
        if (d * row + r >= d * column + c) lower.emplace_back(d * row + r, d * column + c, block(r, c));
      }
    }
  };
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(d, d);
  for (const Edge& edge : graph.edges) {
    const int i = offsets[edge.from.robot] + edge.from.index - 1;  // -1: the pose that is held
    const int j = offsets[edge.to.robot] + edge.to.index - 1;
    const Eigen::MatrixXd R = edge.kappa * rotation_of(edge.measurement, d);
    if (i >= 0) add_block(i, i, edge.kappa * I);
    if (j >= 0) add_block(j, j, edge.kappa * I);
    if (i < 0) B.middleRows(d * j, d) += R.transpose();
    if (j < 0) B.middleRows(d * i, d) += R;
    if (i >= 0 && j >= 0) i > j ? add_block(i, j, -R) : add_block(j, i, -R.transpose());
  }
  std::vector<Eigen::MatrixXd> rotations = {I};
  if (unknowns == 0) return rotations;
  const Eigen::MatrixXd X = solve_positive_definite(unknowns, lower, B);
  for (int i = 0; i + 1 < graph.poses(); ++i) {
    rotations.push_back(project_to_rotation(X.middleRows(d * i, d).transpose()));
  }
  return rotations;
}

// Minimises sum tau |t_to - t_from - R_from t|^2 with the first translation held at zero.
Eigen::MatrixXd best_translations(const PoseGraph& graph, const std::vector<Eigen::MatrixXd>& rotations) {
  const int d = graph.dimension;
  const std::vector<int> offsets = graph.offsets();
  const int unknowns = graph.poses() - 1;
  std::vector<Eigen::Triplet<double>> lower;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(unknowns, d);
  for (const Edge& edge : graph.edges) {
    const int i = offsets[edge.from.robot] + edge.from.index - 1;
    const int j = offsets[edge.to.robot] + edge.to.index - 1;
    const Eigen::VectorXd step = edge.tau * (rotations[i + 1] * translation_of(edge.measurement, d));
    if (i >= 0) lower.emplace_back(i, i, edge.tau), B.row(i) -= step.transpose();
    if (j >= 0) lower.emplace_back(j, j, edge.tau), B.row(j) += step.transpose();
    if (i >= 0 && j >= 0) lower.emplace_back(std::max(i, j), std::min(i, j), -edge.tau);
  }
  Eigen::MatrixXd translations = Eigen::MatrixXd::Zero(unknowns + 1, d);
  if (unknowns > 0) translations.bottomRows(unknowns) = solve_positive_definite(unknowns, lower, B);
  return translations;
}

int anchor_of(const PoseGraph& graph) {
  const auto first =
      std::find_if(graph.poses_per_robot.begin(), graph.poses_per_robot.end(), [](int n) { return n > 0; });
  COVEY_CHECK(first != graph.poses_per_robot.end());
  return static_cast<int>(first - graph.poses_per_robot.begin());
}

void move_into_frames(const PoseGraph& graph, const Frames& frames, Poses& poses) {
  const std::vector<int> offsets = graph.offsets();
  for (int robot = 0; robot < graph.robots(); ++robot) {
    if (!frames.T_W_O[robot]) continue;
    for (int flat = offsets[robot]; flat < offsets[robot + 1]; ++flat)
      poses[flat] = *frames.T_W_O[robot] * poses[flat];
  }
}

// T_A_B by one loop, a the robot that it leaves (Kimera-Multi, T-RO 2022, eq. 4).
SE3 candidate_alignment(const PoseGraph& graph, const Edge& loop, const Poses& poses) {
  const std::vector<int> offsets = graph.offsets();
  const SE3& T_A_i = poses[offsets[loop.from.robot] + loop.from.index];
  const SE3& T_B_j = poses[offsets[loop.to.robot] + loop.to.index];
  return T_A_i * loop.measurement * T_B_j.inverse();
}

}  // namespace

Poses odometry_start(const PoseGraph& graph) {
  const std::vector<int> offsets = graph.offsets();
  // A forest of each robot's own edges, odometry first: with a whole chain it is the chain.
  std::vector<int> parent(graph.poses());
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<std::vector<std::pair<int, SE3>>> neighbours(graph.poses());
  for (const EdgeKind kind : {EdgeKind::kOdometry, EdgeKind::kLoop}) {
    for (const Edge& edge : graph.edges) {
      if (edge.kind != kind || edge.between_robots()) continue;
      const int i = offsets[edge.from.robot] + edge.from.index;
      const int j = offsets[edge.to.robot] + edge.to.index;
      const int a = find_root(parent, i);
      const int b = find_root(parent, j);
      if (a == b) continue;
      parent[a] = b;
      neighbours[i].emplace_back(j, edge.measurement);
      neighbours[j].emplace_back(i, edge.measurement.inverse());
    }
  }
  Poses poses(graph.poses());
  std::vector<bool> reached(poses.size(), false);
  for (int first = 0; first < graph.poses(); ++first) {
    if (reached[first]) continue;
    reached[first] = true;
    std::vector<int> open = {first};
    while (!open.empty()) {
      const int i = open.back();
      open.pop_back();
      for (const auto& [j, T_i_j] : neighbours[i]) {
        if (reached[j]) continue;
        reached[j] = true;
        poses[j] = poses[i] * T_i_j;
        open.push_back(j);
      }
    }
  }
  return poses;
}

Poses chordal_start(const PoseGraph& graph) {
  const std::vector<Eigen::MatrixXd> rotations = relaxed_rotations(graph);
  const Eigen::MatrixXd translations = best_translations(graph, rotations);
  Poses poses;
  for (int i = 0; i < graph.poses(); ++i)
    poses.push_back(pose_of(rotations[i], translations.row(i).transpose()));
  return poses;
}

RobustStart robust_start(const PoseGraph& graph, AlignmentOptions options) {
  options.dimension = graph.dimension;
  RobustStart start;
  start.poses = odometry_start(graph);
  std::map<std::pair<int, int>, std::vector<SE3>> candidates;
  for (const Edge& edge : graph.edges) {
    if (!edge.between_robots()) continue;
    const SE3 T_A_B = candidate_alignment(graph, edge, start.poses);
    const auto& [a, b] = std::pair(edge.from.robot, edge.to.robot);
    candidates[std::minmax(a, b)].push_back(a < b ? T_A_B : T_A_B.inverse());
  }
  for (const auto& [pair, of_pair] : candidates) {
    start.alignments.push_back({pair.first, pair.second, align_pair(of_pair, options)});
  }
  start.frames = spanning_tree(start.alignments, graph.robots(), anchor_of(graph));
  move_into_frames(graph, start.frames, start.poses);
  return start;
}

Poses naive_start(const PoseGraph& graph, std::uint64_t seed) {
  Poses poses = odometry_start(graph);
  std::vector<const Edge*> loops;
  for (const Edge& edge : graph.edges) {
    if (edge.between_robots()) loops.push_back(&edge);
  }
  std::mt19937_64 random(seed);
  std::shuffle(loops.begin(), loops.end(), random);
  // The first loop of each pair is the one that was drawn for it; the tree takes pairs in the order of the
  // draw.
  std::map<std::pair<int, int>, const Edge*> drawn;
  std::vector<PairAlignment> alignments;
  for (const Edge* loop : loops) {
    if (!drawn.emplace(std::minmax(loop->from.robot, loop->to.robot), loop).second) continue;
    PairAlignment pair{loop->from.robot, loop->to.robot, {}};
    pair.alignment.T_A_B = candidate_alignment(graph, *loop, poses);
    pair.alignment.inliers = static_cast<int>(loops.size() - alignments.size());
    pair.alignment.ok = true;
    alignments.push_back(std::move(pair));
  }
  move_into_frames(graph, spanning_tree(alignments, graph.robots(), anchor_of(graph)), poses);
  return poses;
}

}  // namespace covey::pgo
