// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/start.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/stiefel.h"
#include "core/graph/block_cholesky.h"

namespace covey::pgo {
namespace {

int find_root(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

// The ends of an edge in a linear system whose unknowns are all poses but the first, which is held: kHeld, or 0 for the second
// pose and so on.
constexpr int kHeld = -1;
struct Ends {
  int i = kHeld;
  int j = kHeld;
};

std::vector<Ends> ends_of(const PoseGraph& graph) {
  const std::vector<int> offsets = graph.offsets();
  std::vector<Ends> ends;
  ends.reserve(graph.edges.size());
  for (const Edge& edge : graph.edges) {
    ends.push_back(
        {offsets[edge.from.robot] + edge.from.index - 1, offsets[edge.to.robot] + edge.to.index - 1});
  }
  return ends;
}

// The matrix of such a system, zero, with `size` rows for each pose.
graph::BlockCholesky make_system(const PoseGraph& graph, const std::vector<Ends>& ends, int size) {
  std::vector<std::pair<int, int>> pairs;
  pairs.reserve(ends.size());
  for (const auto& [i, j] : ends) {
    if (i != kHeld && j != kHeld) pairs.emplace_back(i, j);
  }
  return {std::vector<int>(graph.poses() - 1, size), pairs};
}

// Minimises sum kappa |R_to - R_from R|_F^2 over d x d matrices with the first one held at identity. Each row
// of a rotation matrix is an unknown of its own: with x_i the transposed row, the residuals are x_to - R^T
// x_from.
std::vector<Eigen::MatrixXd> relaxed_rotations(const PoseGraph& graph, const std::vector<Ends>& ends) {
  const int d = graph.dimension;
  graph::BlockCholesky A = make_system(graph, ends, d);
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(A.rows(), d);
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(d, d);
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const auto [i, j] = ends[e];
    const double kappa = graph.edges[e].kappa;
    const Eigen::MatrixXd R = kappa * rotation_of(graph.edges[e].measurement, d);
    if (i != kHeld) A.add(i, i, kappa * I);
    if (j != kHeld) A.add(j, j, kappa * I);
    if (i != kHeld && j != kHeld) A.add(i, j, -R);
    if (i == kHeld && j != kHeld) B.middleRows(A.first_row(j), d) += R.transpose();
    if (j == kHeld && i != kHeld) B.middleRows(A.first_row(i), d) += R;
  }
  COVEY_CHECK(A.factorise());
  const Eigen::MatrixXd X = A.solve(B);
  std::vector<Eigen::MatrixXd> rotations = {I};
  for (int i = 0; i + 1 < graph.poses(); ++i)
    rotations.push_back(project_to_rotation(X.middleRows(A.first_row(i), d).transpose()));
  return rotations;
}

// Minimises sum tau |t_to - t_from - R_from t|^2 with the first translation held at zero.
Eigen::MatrixXd best_translations(const PoseGraph& graph, const std::vector<Ends>& ends,
                                  const std::vector<Eigen::MatrixXd>& rotations) {
  const int d = graph.dimension;
  graph::BlockCholesky A = make_system(graph, ends, 1);
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(A.rows(), d);
  for (std::size_t e = 0; e < ends.size(); ++e) {
    const auto [i, j] = ends[e];
    const Eigen::Matrix<double, 1, 1> tau(graph.edges[e].tau);
    const Eigen::VectorXd step =
        tau.value() * (rotations[i + 1] * translation_of(graph.edges[e].measurement, d));
    if (i != kHeld) A.add(i, i, tau), B.row(A.first_row(i)) -= step.transpose();
    if (j != kHeld) A.add(j, j, tau), B.row(A.first_row(j)) += step.transpose();
    if (i != kHeld && j != kHeld) A.add(i, j, -tau);
  }
  COVEY_CHECK(A.factorise());
  const Eigen::MatrixXd X = A.solve(B);
  Eigen::MatrixXd translations = Eigen::MatrixXd::Zero(graph.poses(), d);
  for (int i = 0; i + 1 < graph.poses(); ++i) translations.row(i + 1) = X.row(A.first_row(i));
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

// Of the ends of each robot's loops with others, and its first pose.
std::vector<FrameExtent> extents_of(const PoseGraph& graph, const Poses& poses) {
  std::vector<std::set<int>> ends(graph.robots(), {0});
  for (const Edge& edge : graph.edges) {
    if (!edge.between_robots()) continue;
    ends[edge.from.robot].insert(edge.from.index);
    ends[edge.to.robot].insert(edge.to.index);
  }
  const std::vector<int> offsets = graph.offsets();
  std::vector<FrameExtent> extents;
  for (int robot = 0; robot < graph.robots(); ++robot) {
    std::vector<SE3> public_poses;
    for (const int index : ends[robot]) {
      if (index < graph.poses_per_robot[robot]) public_poses.push_back(poses[offsets[robot] + index]);
    }
    extents.push_back(extent_of(public_poses));
  }
  return extents;
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
  const std::vector<Ends> ends = ends_of(graph);
  const std::vector<Eigen::MatrixXd> rotations = relaxed_rotations(graph, ends);
  const Eigen::MatrixXd translations = best_translations(graph, ends, rotations);
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
    for (AlignmentResult& alignment : possible_alignments(of_pair, options)) {
      start.alignments.push_back({pair.first, pair.second, std::move(alignment)});
    }
  }
  start.extents = extents_of(graph, start.poses);
  start.frames = spanning_tree(start.alignments, start.extents, anchor_of(graph));
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
  const std::vector<FrameExtent> extents(graph.robots());
  move_into_frames(graph, spanning_tree(alignments, extents, anchor_of(graph)), poses);
  return poses;
}

}  // namespace covey::pgo
