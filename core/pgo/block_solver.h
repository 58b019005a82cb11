// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One robot's part of the team's pose graph, with the others' poses held fixed: the local step of Riemannian
// block-coordinate descent (RBCD).
//
// Variables. Pose k is lifted to X_k = [Y_k | p_k] in St(r, 3) x R^r, r >= 3; all n poses stand side by side in X, r x 4n.
// With M = [R t; 0 1] of a measurement and Omega = diag(kappa, kappa, kappa, tau), an edge from i to j costs
//
//   w |X_j - X_i M|^2_Omega = w (kappa |Y_j - Y_i R|_F^2 + tau |p_j - p_i - Y_i t|^2)
//
// which for r = 3 and Y a rotation is the squared residual of CONVENTIONS.md. A shared edge has one end that is mine and a
// fixed r x 4 target in place of the other: |X_j - target|^2_Omega when its `to` is mine, |X_i M - target|^2_Omega when its
// `from` is. So the whole is a quadratic on a product of Stiefel manifolds and Euclidean spaces,
//
//   F(X) = tr(X Q X^T) + 2 tr(G X^T) + c,       Q 4n x 4n, sparse; G r x 4n
//
// minimised by a Riemannian trust region with truncated conjugate gradients. A step never increases F.
//
// Preconditioner. Moving each pose in its own frame, V_k = [Y_k hat(omega_k) | Y_k v_k], an edge whose residual is zero changes
// by kappa 2 |omega_j - R^T omega_i|^2 + tau |R v_j - v_i + hat(t) omega_i|^2: there the Hessian depends on the measurements
// alone, not on the poses. So H, 6n x 6n, is factorised once, and again only after weights have changed much. Where a start
// of rank 3 moves at all it moves like this. What is normal to the range of Y_k (r > 3 only) is preconditioned by Q, whose
// factor is made when such a part first turns up.
//
// Rows of X that are zero throughout stay zero to the last bit (a gradient has no part in them), and nothing is spent on them.
//
// Sources: Tian, Khosoussi, Rosen, How, "Distributed Certifiably Correct Pose-Graph Optimization", T-RO 2021 (RBCD);
// Absil, Mahony, Sepulchre, "Optimization Algorithms on Matrix Manifolds", 2008, chapter 7 (trust region).

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"
#include "core/graph/block_cholesky.h"

namespace covey::pgo {

using Lifted = Eigen::MatrixXd;  // r x 4n

// [I; 0] R, [I; 0] t: a pose as a lifted pose (r x 4) in the standard lifting that all robots share.
Lifted lift(const SE3& T, int rank);
// The pose of X_k (r x 4) seen from the lifted anchor X_a: the lifting and the anchor's own pose cancel.
SE3 round_to_pose(const Lifted& X_a, const Lifted& X_k);

struct PrivateEdge {  // both poses are mine
  int from = 0;
  int to = 0;
  SE3 measurement;  // T_from_to
  double kappa = 1.0;
  double tau = 1.0;
};

struct SharedEdge {  // one pose is mine
  int mine = 0;
  bool mine_is_from = true;
  SE3 measurement;  // T_from_to
  double kappa = 1.0;
  double tau = 1.0;
};

// The two sides of a shared edge's residual, from my pose and from the other robot's (r x 4 each): F sees their difference.
Lifted my_side(const SharedEdge& edge, const Lifted& mine);
Lifted other_side(const SharedEdge& edge, const Lifted& other);
// |difference|^2_Omega of an r x 4 difference of sides.
double weighted_square(const Lifted& difference, double kappa, double tau);

// Pose-wise retraction of a step V from X: polar on the Stiefel manifolds, the sum on translations.
Lifted retract(const Lifted& X, const Lifted& V);

struct BlockSolverOptions {
  int max_outer = 3;   // accepted trust-region steps per call
  int max_inner = 50;  // conjugate-gradient steps per trust-region step
  // A trust-region step is good enough when what is left of its gradient has fallen by this factor, in the norm of the
  // preconditioner, whose square is twice the decrease that is still to be had.
  double inner_tolerance = 1e-2;
  double gradient_tolerance =
      1e-4;  // stop when the gradient's norm has fallen by this factor within the call
  double absolute_gradient_tolerance = 1e-7;  // or is below this
  double refactor_change = 0.3;               // largest change of a weight that the preconditioner tolerates
};

struct BlockStep {           // evidence
  double cost_before = 0.0;  // F, of this robot's edges
  double cost_after = 0.0;
  double gradient_before = 0.0;  // norm of the Riemannian gradient
  double gradient_after = 0.0;
  int outer = 0;
  int inner = 0;
};

class BlockSolver {
 public:
  BlockSolver(int poses, int rank, std::vector<PrivateEdge> edges, std::vector<SharedEdge> shared,
              const BlockSolverOptions& options = {});

  int poses() const { return poses_; }
  int rank() const { return rank_; }
  const std::vector<PrivateEdge>& edges() const { return edges_; }
  const std::vector<SharedEdge>& shared() const { return shared_; }

  // In the order of the edges; all 1 before the first call.
  void set_weights(const Eigen::VectorXd& edges, const Eigen::VectorXd& shared);

  // One local minimisation; targets is r x 4m, in the order of the shared edges.
  BlockStep minimise(const Lifted& targets, Lifted& X);

  double cost(const Lifted& targets, const Lifted& X) const;
  // 2 (X Q + G): linear in (targets, X) together, so that of a motion of all robots it is the Hessian times that motion.
  Lifted euclidean_gradient(const Lifted& targets, const Lifted& X) const;
  Lifted riemannian_gradient(const Lifted& targets, const Lifted& X) const;

  // Unweighted squared residuals at X.
  Eigen::VectorXd edge_residuals(const Lifted& X) const;
  Eigen::VectorXd shared_residuals(const Lifted& targets, const Lifted& X) const;

 private:
  template <int R>
  using Rows = Eigen::Matrix<double, R,
                             Eigen::Dynamic>;  // the first rows of a Lifted, R = 3 where the others are zero
  struct Term {  // an edge, weighted; from or to is -1 where the end is another robot's
    int from;
    int to;
    Eigen::Matrix3d R;
    Eigen::Vector3d t;
    double kappa;
    double tau;
  };

  void weigh_terms();
  void factorise();
  void factorise_q();
  template <int R>
  double evaluate(const Rows<R>* targets, const Rows<R>& X, Rows<R>* gradient) const;
  template <int R>
  BlockStep descend(const Rows<R>& targets, Rows<R>& X);
  template <int R>
  double solve_trust_region(const Rows<R>& X, const Rows<R>& euclidean, const Rows<R>& gradient,
                            double radius, Rows<R>& step, int& iterations) const;
  template <int R>
  void precondition(const Rows<R>& X, const Rows<R>& V, Rows<R>& result) const;

  int poses_;
  int rank_;
  BlockSolverOptions options_;
  std::vector<PrivateEdge> edges_;
  std::vector<SharedEdge> shared_;
  Eigen::VectorXd edge_weights_;
  Eigen::VectorXd shared_weights_;
  std::vector<Term> private_terms_;
  std::vector<Term> shared_terms_;
  Eigen::VectorXd factored_edge_weights_;
  Eigen::VectorXd factored_shared_weights_;
  std::optional<graph::BlockCholesky> motions_;  // the factor of H
  std::optional<graph::BlockCholesky> normal_;   // of Q
};

}  // namespace covey::pgo
