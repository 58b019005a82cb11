// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A pose graph of one or several robots: poses to be estimated, and measured relative poses between them.
//
// Each robot's poses are numbered 0, 1, ... without gaps; the flat index of a pose counts through robot 0,
// then robot 1 and so on, and vectors of poses are in flat order. A robot may have no poses. An edge measures
// T_from_to with rotation precision kappa and translation precision tau, so that its squared residual is
//
//   kappa |R_to - R_from R|_F^2 + tau |t_to - t_from - R_from t|^2        (CONVENTIONS.md, Pose-graph cost)
//
// A planar graph (dimension 2) is kept as rigid motions in the plane z = 0 about z; the residual above is
// then the same number for its 3x3 and for its 2x2 rotations. rotation_of, translation_of and pose_of convert
// to d x d and d.

#include <Eigen/Core>
#include <compare>
#include <vector>

#include "core/geometry/se3.h"

namespace covey::pgo {

struct PoseId {
  int robot = 0;
  int index = 0;
  auto operator<=>(const PoseId&) const = default;
};

enum class EdgeKind { kOdometry, kLoop };

struct Edge {
  PoseId from;
  PoseId to;
  SE3 measurement;     // T_from_to
  double kappa = 1.0;  // 1 / rad^2
  double tau = 1.0;    // 1 / m^2
  EdgeKind kind = EdgeKind::kLoop;
  bool known_inlier = false;  // robust solvers keep its weight at 1

  bool between_robots() const { return from.robot != to.robot; }
};

using Poses = std::vector<SE3>;  // T_W_pose, in flat order

struct PoseGraph {
  int dimension = 3;                 // 2 or 3
  std::vector<int> poses_per_robot;  // one entry per robot, 0 for a robot without poses
  std::vector<Edge> edges;

  int robots() const { return static_cast<int>(poses_per_robot.size()); }
  int poses() const;
  int loops() const;
  // Flat index of each robot's first pose, and one entry more: the number of poses.
  std::vector<int> offsets() const;
};

// 0, 1, ... for each pose, equal for poses that edges join; parts are numbered in the order of their first
// pose.
std::vector<int> connected_parts(const PoseGraph& graph);

// The same graph as that of one robot; flat indices stay.
PoseGraph as_one_robot(const PoseGraph& graph);

// The edges whose two robots both have odometry (or one single pose), and how many edges fell away. One
// robot's file names poses of robots whose own files are not at hand; such poses cannot be estimated.
struct Restriction {
  PoseGraph graph;
  int dropped_edges = 0;
};
Restriction keep_robots_with_odometry(const PoseGraph& graph);

// For robust solvers: the same graph with kappa halved in 2D. There kappa counts a rotation twice (|.|_F^2 is
// 2 theta^2 for a small angle while kappa is the precision of theta), so that with it the squared residual is
// chi-square distributed with 3 degrees of freedom; in 3D with 6, and nothing changes.
PoseGraph robust_form(PoseGraph graph);

// d x d rotation, d-vector translation, and back.
Eigen::MatrixXd rotation_of(const SE3& T, int dimension);
Eigen::VectorXd translation_of(const SE3& T, int dimension);
SE3 pose_of(const Eigen::MatrixXd& rotation, const Eigen::VectorXd& translation);

}  // namespace covey::pgo
