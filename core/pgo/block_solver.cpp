// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/block_solver.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/stiefel.h"

namespace covey::pgo {
namespace {

constexpr int kMaxRejected = 20;  // trial steps per call; each quarters the radius

Eigen::Vector4d omega(double kappa, double tau) { return {kappa, kappa, kappa, tau}; }

// out (r x 4) += X (r x 4) * M, on raw columns: r is a run-time size too small for Eigen's general product.
void add_product(const double* X, const Eigen::Matrix4d& M, int rank, double* out) {
  for (int c = 0; c < 4; ++c) {
    for (int k = 0; k < 4; ++k) {
      const double m = M(k, c);
      for (int a = 0; a < rank; ++a) out[c * rank + a] += X[k * rank + a] * m;
    }
  }
}

Lifted times_measurement(const Lifted& X, const SE3& measurement) { return X * measurement.matrix(); }

double inner_product(const Lifted& A, const Lifted& B) { return A.cwiseProduct(B).sum(); }

// V minus its part normal to the Stiefel manifolds at X, pose by pose; translations are free.
void project_to_tangent_space(const Lifted& X, Lifted& V) {
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    const auto Y = X.middleCols<3>(k);
    auto U = V.middleCols<3>(k);
    const Eigen::Matrix3d S = Y.transpose() * U;
    U -= Y.lazyProduct(0.5 * (S + S.transpose()));
  }
}

// The curvature that the constraint adds to the Euclidean Hessian: V_k sym(Y_k^T E_k), E the Euclidean gradient.
void subtract_curvature(const Lifted& X, const Lifted& euclidean, const Lifted& V, Lifted& hessian) {
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    const Eigen::Matrix3d S = X.middleCols<3>(k).transpose() * euclidean.middleCols<3>(k);
    hessian.middleCols<3>(k) -= V.middleCols<3>(k).lazyProduct(0.5 * (S + S.transpose()));
  }
}

// The root tau >= 0 of |step + tau direction| = radius.
double to_boundary(const Lifted& step, const Lifted& direction, double radius) {
  const double dd = direction.squaredNorm();
  const double sd = inner_product(step, direction);
  return (-sd + std::sqrt(sd * sd + dd * (radius * radius - step.squaredNorm()))) / dd;
}

}  // namespace

Lifted retract(const Lifted& X, const Lifted& V) {
  Lifted result = X + V;
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    auto Y = result.middleCols<3>(k);
    // (Y + V) ((Y + V)^T (Y + V))^-1/2, by the 3 x 3 Gram matrix.
    const Eigen::Matrix3d gram = Y.transpose() * Y;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(gram);
    const Lifted polar = Y.lazyProduct(eigen.operatorInverseSqrt());
    Y = polar;
  }
  return result;
}

Lifted lift(const SE3& T, int rank) {
  Lifted X = Lifted::Zero(rank, 4);
  X.topRows<3>() = T.matrix().topRows<3>();
  return X;
}

SE3 round_to_pose(const Lifted& X_a, const Lifted& X_k) {
  SE3 T;
  T.rotation = SO3::from_matrix(round_lifted(X_k.leftCols<3>(), X_a.leftCols<3>()));
  T.translation = X_a.leftCols<3>().transpose() * (X_k.col(3) - X_a.col(3));
  return T;
}

Lifted my_side(const SharedEdge& edge, const Lifted& mine) {
  return edge.mine_is_from ? times_measurement(mine, edge.measurement) : mine;
}

Lifted other_side(const SharedEdge& edge, const Lifted& other) {
  return edge.mine_is_from ? other : times_measurement(other, edge.measurement);
}

double weighted_square(const Lifted& difference, double kappa, double tau) {
  return kappa * difference.leftCols<3>().squaredNorm() + tau * difference.col(3).squaredNorm();
}

BlockSolver::BlockSolver(int poses, int rank, std::vector<PrivateEdge> edges, std::vector<SharedEdge> shared,
                         const BlockSolverOptions& options)
    : poses_(poses),
      rank_(rank),
      options_(options),
      edges_(std::move(edges)),
      shared_(std::move(shared)),
      edge_weights_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(edges_.size()))),
      shared_weights_(Eigen::VectorXd::Ones(static_cast<Eigen::Index>(shared_.size()))) {
  COVEY_CHECK(poses > 0 && rank >= 3);
  assemble();
}

void BlockSolver::set_weights(const Eigen::VectorXd& edges, const Eigen::VectorXd& shared) {
  COVEY_CHECK(edges.size() == edge_weights_.size() && shared.size() == shared_weights_.size());
  edge_weights_ = edges;
  shared_weights_ = shared;
  assemble();
}

void BlockSolver::assemble() {
  columns_.assign(poses_, {});
  for (int k = 0; k < poses_; ++k) columns_[k].push_back({k, Eigen::Matrix4d::Zero()});
  const auto add = [this](int row, int column, const Eigen::Matrix4d& value) {
    auto& blocks = columns_[column];
    const auto found =
        std::find_if(blocks.begin(), blocks.end(), [row](const Block& block) { return block.row == row; });
    if (found == blocks.end()) {
      blocks.push_back({row, value});
    } else {
      found->value += value;
    }
  };
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const PrivateEdge& edge = edges_[e];
    const Eigen::Matrix4d M = edge.measurement.matrix();
    const Eigen::Matrix4d W = (edge_weights_[e] * omega(edge.kappa, edge.tau)).asDiagonal();
    const Eigen::Matrix4d MW = M * W;
    add(edge.to, edge.to, W);
    add(edge.from, edge.from, MW * M.transpose());
    add(edge.from, edge.to, -MW);
    add(edge.to, edge.from, -MW.transpose());
  }
  for (std::size_t e = 0; e < shared_.size(); ++e) {
    const SharedEdge& edge = shared_[e];
    const Eigen::Matrix4d W = (shared_weights_[e] * omega(edge.kappa, edge.tau)).asDiagonal();
    if (edge.mine_is_from) {
      const Eigen::Matrix4d M = edge.measurement.matrix();
      add(edge.mine, edge.mine, M * W * M.transpose());
    } else {
      add(edge.mine, edge.mine, W);
    }
  }
}

void BlockSolver::factorise() {
  const auto drift = [](const Eigen::VectorXd& now, const Eigen::VectorXd& then) {
    return now.size() == 0 ? 0.0 : (now - then).cwiseAbs().maxCoeff();
  };
  if (analysed_ && drift(edge_weights_, factored_edge_weights_) < options_.refactor_change &&
      drift(shared_weights_, factored_shared_weights_) < options_.refactor_change) {
    return;
  }
  std::vector<Eigen::Triplet<double>> triplets;
  double trace = 0.0;
  for (int column = 0; column < poses_; ++column) {
    trace += columns_[column].front().value.trace();
    for (const Block& block : columns_[column]) {
      if (block.row < column) continue;
      for (int c = 0; c < 4; ++c) {
        for (int r = 0; r < 4; ++r)
          triplets.emplace_back(4 * block.row + r, 4 * column + c, block.value(r, c));
      }
    }
  }
  // Relative to Q's mean diagonal: without shared edges Q is singular (the poses may move together).
  const double shift = 1e-7 * trace / (4.0 * poses_) + 1e-12;
  for (int i = 0; i < 4 * poses_; ++i) triplets.emplace_back(i, i, shift);
  Eigen::SparseMatrix<double> matrix(4 * poses_, 4 * poses_);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  if (!analysed_) {
    preconditioner_.analyzePattern(matrix);  // weights change values, never the pattern
    analysed_ = true;
  }
  preconditioner_.factorize(matrix);
  factored_edge_weights_ = edge_weights_;
  factored_shared_weights_ = shared_weights_;
}

Lifted BlockSolver::times_q(const Lifted& X) const {
  Lifted result = Lifted::Zero(rank_, 4 * poses_);
  const std::ptrdiff_t stride = 4 * static_cast<std::ptrdiff_t>(rank_);
  for (int column = 0; column < poses_; ++column) {
    for (const Block& block : columns_[column]) {
      add_product(X.data() + block.row * stride, block.value, rank_, result.data() + column * stride);
    }
  }
  return result;
}

Lifted BlockSolver::linear_term(const Lifted& targets) const {
  Lifted G = Lifted::Zero(rank_, 4 * poses_);
  for (std::size_t e = 0; e < shared_.size(); ++e) {
    const SharedEdge& edge = shared_[e];
    const Eigen::Vector4d w = shared_weights_[e] * omega(edge.kappa, edge.tau);
    const Lifted weighted = targets.middleCols<4>(4 * static_cast<Eigen::Index>(e)) * w.asDiagonal();
    auto out = G.middleCols<4>(4 * edge.mine);
    if (edge.mine_is_from) {
      out -= weighted * edge.measurement.matrix().transpose();
    } else {
      out -= weighted;
    }
  }
  return G;
}

double BlockSolver::cost(const Lifted& targets, const Lifted& X) const {
  return edge_weights_.dot(edge_residuals(X)) + shared_weights_.dot(shared_residuals(targets, X));
}

Lifted BlockSolver::riemannian_gradient(const Lifted& targets, const Lifted& X) const {
  Lifted gradient = 2.0 * (times_q(X) + linear_term(targets));
  project_to_tangent_space(X, gradient);
  return gradient;
}

Eigen::VectorXd BlockSolver::edge_residuals(const Lifted& X) const {
  Eigen::VectorXd r2(static_cast<Eigen::Index>(edges_.size()));
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    const PrivateEdge& edge = edges_[e];
    const Lifted predicted = times_measurement(X.middleCols<4>(4 * edge.from), edge.measurement);
    r2[e] = weighted_square(X.middleCols<4>(4 * edge.to) - predicted, edge.kappa, edge.tau);
  }
  return r2;
}

Eigen::VectorXd BlockSolver::shared_residuals(const Lifted& targets, const Lifted& X) const {
  Eigen::VectorXd r2(static_cast<Eigen::Index>(shared_.size()));
  for (int e = 0; e < static_cast<int>(shared_.size()); ++e) {
    r2[e] = weighted_square(
        my_side(shared_[e], X.middleCols<4>(4 * shared_[e].mine)) - targets.middleCols<4>(4 * e),
        shared_[e].kappa, shared_[e].tau);
  }
  return r2;
}

Lifted BlockSolver::precondition(const Lifted& X, const Lifted& V) const {
  const Lifted solved = preconditioner_.solve(Lifted(V.transpose()));
  Lifted result = solved.transpose();
  project_to_tangent_space(X, result);
  return result;
}

BlockStep BlockSolver::minimise(const Lifted& targets, Lifted& X) {
  COVEY_CHECK(X.rows() == rank_ && X.cols() == 4 * poses_);
  factorise();
  BlockStep report;
  const Lifted start = X;
  const Lifted G = linear_term(targets);
  const auto euclidean_at = [&](const Lifted& at) -> Lifted { return 2.0 * (times_q(at) + G); };
  Lifted euclidean = euclidean_at(X);
  Lifted gradient = euclidean;
  project_to_tangent_space(X, gradient);
  double value = cost(targets, X);
  report.cost_before = value;
  report.gradient_before = gradient.norm();
  const double tolerance =
      std::max(options_.absolute_gradient_tolerance, options_.gradient_tolerance * report.gradient_before);
  double radius = 10.0 * std::sqrt(static_cast<double>(poses_));
  Lifted step;
  for (int rejected = 0; report.outer < options_.max_outer && gradient.norm() > tolerance;) {
    const double predicted = solve_trust_region(X, euclidean, gradient, radius, step, report.inner);
    const Lifted candidate = retract(X, step);
    const double candidate_value = cost(targets, candidate);
    const double ratio = predicted > 0.0 ? (value - candidate_value) / predicted : -1.0;
    if (ratio < 0.25) {
      radius = 0.25 * std::min(radius, step.norm());
    } else if (ratio > 0.75 && step.norm() > 0.99 * radius) {
      radius *= 2.0;
    }
    if (!(ratio >= 0.1)) {  // not a number, too: nothing worse than before is taken
      if (++rejected > kMaxRejected) break;
      continue;
    }
    ++report.outer;
    X = candidate;
    value = candidate_value;
    euclidean = euclidean_at(X);
    gradient = euclidean;
    project_to_tangent_space(X, gradient);
  }
  report.cost_after = value;
  report.gradient_after = gradient.norm();
  report.change = (X - start).norm() / std::sqrt(static_cast<double>(poses_));
  return report;
}

// Steihaug-Toint truncated conjugate gradients on the quadratic model; returns the decrease that the model predicts.
double BlockSolver::solve_trust_region(const Lifted& X, const Lifted& euclidean, const Lifted& gradient,
                                       double radius, Lifted& step, int& iterations) const {
  const auto hessian_times = [&](const Lifted& V) {
    Lifted H = 2.0 * times_q(V);
    subtract_curvature(X, euclidean, V, H);
    project_to_tangent_space(X, H);
    return H;
  };
  step = Lifted::Zero(rank_, 4 * poses_);
  Lifted hessian_step = step;
  Lifted residual = gradient;
  Lifted preconditioned = precondition(X, residual);
  Lifted direction = -preconditioned;
  double rz = inner_product(residual, preconditioned);
  const double stop = std::max(0.1 * options_.absolute_gradient_tolerance,
                               0.1 * options_.gradient_tolerance * gradient.norm());
  for (int i = 0; i < options_.max_inner; ++i) {
    ++iterations;
    const Lifted H = hessian_times(direction);
    const double curvature = inner_product(direction, H);
    const double alpha = rz / curvature;
    if (curvature <= 0.0 || (step + alpha * direction).norm() >= radius) {
      const double length = to_boundary(step, direction, radius);
      step += length * direction;
      hessian_step += length * H;
      break;
    }
    step += alpha * direction;
    hessian_step += alpha * H;
    residual += alpha * H;
    if (residual.norm() < stop) break;
    preconditioned = precondition(X, residual);
    const double next = inner_product(residual, preconditioned);
    direction = -preconditioned + (next / rz) * direction;
    rz = next;
  }
  return -inner_product(gradient, step) - 0.5 * inner_product(step, hessian_step);
}

}  // namespace covey::pgo
