// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A step of a planar team along smooth motions, by all at once. Where many loops tie two long trajectories to each other block updates
// move both by little, since each robot takes the other's poses for what they are: the error that is left is one slow wave (KITTI
// 00). The nodes of coarse_graph.h span such waves: each node n moves in the plane by (v_n, phi_n), and a keyframe k between two of
// them by what it would move with each as one rigid body, by parts as it lies between them,
//
//   phi_k = sum a_n phi_n,   v_k = sum a_n (v_n + phi_n x (t_k - t_n))
//
// For these steps d the cost is F + g^T d + d^T H d / 2 with an edge's residual changing by kappa 2 (phi_j - phi_i)^2 +
// tau |v_j - v_i - phi_i x R_i t|^2. A robot knows g of its own nodes, and H of its edges and of the loops that it owns: it says
// both, all add them and solve H d = -g, and everybody moves its own poses and everybody's public ones. The root's node stays.
//
// Source: the coarse space of two-level methods (Smith, Bjorstad, Gropp, "Domain Decomposition", 1996, chapter 2).

#include <Eigen/Core>
#include <covey/dpgo_coarse_t.hpp>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/pgo/agreed_problem.h"
#include "core/pgo/block_solver.h"

namespace covey::pgo {

class CoarseStep {
 public:
  using Poses = std::map<int, std::vector<SE3>>;  // everybody's public ones, as all know them

  explicit CoarseStep(const AgreedProblem& problem);

  // Whether there are nodes enough, and not too many.
  bool useful() const;

  // This robot's part: the gradient, and the Hessian where it is wanted.
  void write_gradient(const Lifted& X, const Lifted& gradient, const Poses& known,
                      dpgo_coarse_t& message) const;
  void write_hessian(const BlockSolver& solver, const Eigen::VectorXd& edge_weights,
                     const Eigen::VectorXd& shared_weights, const Lifted& X, const Poses& known,
                     dpgo_coarse_t& message) const;
  bool fits(int robot, const dpgo_coarse_t& message) const;

  // From all members' messages. False where they do not say a step.
  bool solve(const std::map<int, const dpgo_coarse_t*>& messages);
  // By the step that was solved for; known: before any of them is moved.
  void move(const Poses& known, Lifted& own) const;
  void move(const Poses& known, int robot, std::vector<SE3>& poses) const;

 private:
  struct Node {
    int robot = 0;
    int place = 0;  // among its robot's public keyframes
  };
  struct Share {  // of the motion of the nodes before and after
    int before = 0;
    int after = 0;
    double part = 0.0;  // of the latter
  };

  Share share(int robot, int segment, int id) const;
  Eigen::Matrix3d with(int node, double part, const Eigen::Vector2d& position, const Poses& known) const;
  Eigen::Vector3d step_at(const Share& share, const Eigen::Vector2d& position, const Poses& known) const;

  const AgreedProblem& problem_;
  std::vector<Node> nodes_;
  std::map<StartFrame, std::map<int, int>> by_id_;                          // nodes of each segment
  std::map<int, std::pair<int, int>> of_robot_;                             // first node, and how many
  std::vector<Share> own_;                                                  // of own poses
  std::map<int, std::vector<Share>> public_;                                // of everybody's public keyframes
  std::map<int, std::map<std::pair<int, int>, Eigen::Matrix3d>> hessians_;  // by robot, as said last
  Eigen::VectorXd step_;
};

}  // namespace covey::pgo
