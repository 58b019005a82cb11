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

Lifted times_measurement(const Lifted& X, const SE3& measurement) { return X * measurement.matrix(); }

template <typename A, typename B>
double inner_product(const A& a, const B& b) {
  return a.cwiseProduct(b).sum();
}

// gram^-1/2 of a symmetric positive definite matrix. Near the identity, where retractions of all but wild steps are, by
// Newton-Schulz: Z <- Z (3 I - Z gram Z) / 2.
Eigen::Matrix3d inverse_square_root(const Eigen::Matrix3d& gram) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  if (!((gram - I).squaredNorm() < 0.1))
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(gram).operatorInverseSqrt();
  Eigen::Matrix3d Z = I;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Matrix3d error = I - Z.lazyProduct(gram.lazyProduct(Z).eval());
    Z += 0.5 * Z.lazyProduct(error).eval();
    if (error.squaredNorm() < 1e-18) break;  // what is left is its square
  }
  return Z;
}

template <typename Rows>
Rows retracted(const Rows& X, const Rows& V) {
  Rows result = X + V;
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    auto Y = result.template middleCols<3>(k);
    // (Y + V) ((Y + V)^T (Y + V))^-1/2
    const Eigen::Matrix3d root = inverse_square_root(Y.transpose().lazyProduct(Y));
    const Eigen::Matrix<double, Rows::RowsAtCompileTime, 3> polar = Y.lazyProduct(root);
    Y = polar;
  }
  return result;
}

// V minus its part normal to the Stiefel manifolds at X, pose by pose; translations are free.
template <typename Rows>
void project_to_tangent_space(const Rows& X, Rows& V) {
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    const auto Y = X.template middleCols<3>(k);
    auto U = V.template middleCols<3>(k);
    const Eigen::Matrix3d S = Y.transpose().lazyProduct(U);
    U -= Y.lazyProduct((0.5 * (S + S.transpose())).eval());
  }
}

// The curvature that the constraint adds to the Euclidean Hessian: V_k sym(Y_k^T E_k), E the Euclidean gradient.
template <typename Rows>
void subtract_curvature(const Rows& X, const Rows& euclidean, const Rows& V, Rows& hessian) {
  for (Eigen::Index k = 0; k < X.cols(); k += 4) {
    const Eigen::Matrix3d S =
        X.template middleCols<3>(k).transpose().lazyProduct(euclidean.template middleCols<3>(k));
    hessian.template middleCols<3>(k) -=
        V.template middleCols<3>(k).lazyProduct((0.5 * (S + S.transpose())).eval());
  }
}

// The root tau >= 0 of |step + tau direction| = radius.
template <typename Rows>
double to_boundary(const Rows& step, const Rows& direction, double radius) {
  const double dd = direction.squaredNorm();
  const double sd = inner_product(step, direction);
  return (-sd + std::sqrt(sd * sd + dd * (radius * radius - step.squaredNorm()))) / dd;
}

int rows_in_use(const Lifted& X) {
  int rows = static_cast<int>(X.rows());
  while (rows > 3 && (X.row(rows - 1).array() == 0.0).all()) --rows;
  return rows;
}

double drift(const Eigen::VectorXd& now, const Eigen::VectorXd& then) {
  return now.size() == 0 ? 0.0 : (now - then).cwiseAbs().maxCoeff();
}

// Without shared edges all poses may move together, so H and Q are singular by themselves; the shift is relative to each
// diagonal entry, since precisions may differ by ten orders of magnitude.
void factorise_shifted(graph::BlockCholesky& matrix) {
  const Eigen::VectorXd diagonal = matrix.diagonal();
  double shift = 1e-9;
  while (!matrix.factorise(((shift * diagonal).array() + 1e-12).matrix())) {
    shift *= 100.0;
    COVEY_CHECK(shift < 1.0);
  }
}

std::vector<std::pair<int, int>> pairs_of(const std::vector<PrivateEdge>& edges) {
  std::vector<std::pair<int, int>> pairs;
  for (const PrivateEdge& edge : edges) pairs.emplace_back(edge.from, edge.to);
  return pairs;
}

}  // namespace

Lifted retract(const Lifted& X, const Lifted& V) { return retracted(X, V); }

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
  for (const PrivateEdge& edge : edges_) {
    private_terms_.push_back(
        {edge.from, edge.to, edge.measurement.rotation.matrix(), edge.measurement.translation, 0.0, 0.0});
  }
  for (const SharedEdge& edge : shared_) {
    shared_terms_.push_back({edge.mine_is_from ? edge.mine : -1, edge.mine_is_from ? -1 : edge.mine,
                             edge.measurement.rotation.matrix(), edge.measurement.translation, 0.0, 0.0});
  }
  weigh_terms();
}

void BlockSolver::set_weights(const Eigen::VectorXd& edges, const Eigen::VectorXd& shared) {
  COVEY_CHECK(edges.size() == edge_weights_.size() && shared.size() == shared_weights_.size());
  edge_weights_ = edges;
  shared_weights_ = shared;
  weigh_terms();
}

void BlockSolver::weigh_terms() {
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    private_terms_[e].kappa = edge_weights_[e] * edges_[e].kappa;
    private_terms_[e].tau = edge_weights_[e] * edges_[e].tau;
  }
  for (std::size_t e = 0; e < shared_.size(); ++e) {
    shared_terms_[e].kappa = shared_weights_[e] * shared_[e].kappa;
    shared_terms_[e].tau = shared_weights_[e] * shared_[e].tau;
  }
}

// H of the header: the Hessian over motions (v, omega) of each pose in its own frame, at residual zero.
void BlockSolver::factorise() {
  if (motions_ && drift(edge_weights_, factored_edge_weights_) < options_.refactor_change &&
      drift(shared_weights_, factored_shared_weights_) < options_.refactor_change) {
    return;
  }
  if (!motions_) motions_.emplace(std::vector<int>(poses_, 6), pairs_of(edges_));
  motions_->set_zero();
  const auto weights = [](const Term& term) {
    Vector6d w;
    w << Eigen::Vector3d::Constant(2.0 * term.tau), Eigen::Vector3d::Constant(4.0 * term.kappa);
    return w;
  };
  const auto jacobian_from = [](const Term& term) {
    Matrix6d J = Matrix6d::Zero();
    J.topLeftCorner<3, 3>() = -Eigen::Matrix3d::Identity();
    J.topRightCorner<3, 3>() = hat(term.t);
    J.bottomRightCorner<3, 3>() = -term.R.transpose();
    return J;
  };
  for (const auto* terms : {&private_terms_, &shared_terms_}) {
    for (const Term& term : *terms) {
      const Vector6d w = weights(term);
      if (term.to >= 0)
        motions_->add(term.to, term.to, Matrix6d(w.asDiagonal()));  // its Jacobian is a rotation
      if (term.from < 0) continue;
      const Matrix6d J = jacobian_from(term);
      const Matrix6d Jw = J.transpose() * w.asDiagonal();
      motions_->add(term.from, term.from, Jw * J);
      if (term.to < 0) continue;
      Matrix6d block = Jw;
      block.leftCols<3>() = Jw.leftCols<3>() * term.R;
      motions_->add(term.from, term.to, block);
    }
  }
  factorise_shifted(*motions_);
  factored_edge_weights_ = edge_weights_;
  factored_shared_weights_ = shared_weights_;
  if (normal_) factorise_q();
}

void BlockSolver::factorise_q() {
  if (!normal_) normal_.emplace(std::vector<int>(poses_, 4), pairs_of(edges_));
  normal_->set_zero();
  for (const auto* terms : {&private_terms_, &shared_terms_}) {
    for (const Term& term : *terms) {
      const Eigen::Vector4d w = 2.0 * Eigen::Vector4d(term.kappa, term.kappa, term.kappa, term.tau);
      if (term.to >= 0) normal_->add(term.to, term.to, Eigen::Matrix4d(w.asDiagonal()));
      if (term.from < 0) continue;
      Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
      M.topLeftCorner<3, 3>() = term.R;
      M.topRightCorner<3, 1>() = term.t;
      const Eigen::Matrix4d MW = M * w.asDiagonal();
      normal_->add(term.from, term.from, MW * M.transpose());
      if (term.to >= 0) normal_->add(term.from, term.to, -MW);
    }
  }
  factorise_shifted(*normal_);
}

// F and, where asked for, its Euclidean gradient; without targets these are zero. Edge by edge: X Q X^T would lose the cost's
// digits where poses are far from the origin.
template <int R>
double BlockSolver::evaluate(const Rows<R>* targets, const Rows<R>& X, Rows<R>* gradient) const {
  using Rotation = Eigen::Matrix<double, R, 3>;
  using Translation = Eigen::Matrix<double, R, 1>;
  double cost = 0.0;
  if (gradient != nullptr) gradient->setZero(X.rows(), X.cols());
  Rotation dY(X.rows(), 3);
  Translation dp(X.rows());
  const auto minus_from = [&](const Term& term) {
    const auto Y = X.template middleCols<3>(4 * term.from);
    dY.noalias() -= Y.lazyProduct(term.R);
    dp.noalias() -= Y.lazyProduct(term.t);
    dp -= X.col(4 * term.from + 3);
  };
  const auto add_up = [&](const Term& term) {
    cost += term.kappa * dY.squaredNorm() + term.tau * dp.squaredNorm();
    if (gradient == nullptr) return;
    dY *= 2.0 * term.kappa;
    dp *= 2.0 * term.tau;
    if (term.to >= 0) {
      gradient->template middleCols<3>(4 * term.to) += dY;
      gradient->col(4 * term.to + 3) += dp;
    }
    if (term.from >= 0) {
      auto out = gradient->template middleCols<3>(4 * term.from);
      out.noalias() -= dY.lazyProduct(term.R.transpose());
      out.noalias() -= dp.lazyProduct(term.t.transpose());
      gradient->col(4 * term.from + 3) -= dp;
    }
  };
  for (const Term& term : private_terms_) {
    dY = X.template middleCols<3>(4 * term.to);
    dp = X.col(4 * term.to + 3);
    minus_from(term);
    add_up(term);
  }
  for (std::size_t e = 0; e < shared_terms_.size(); ++e) {
    const Term& term = shared_terms_[e];
    dY.setZero();
    dp.setZero();
    if (targets != nullptr) {
      dY = targets->template middleCols<3>(4 * static_cast<Eigen::Index>(e));
      dp = targets->col(4 * static_cast<Eigen::Index>(e) + 3);
    }
    if (term.from >= 0) {
      minus_from(term);
    } else {
      dY = X.template middleCols<3>(4 * term.to) - dY;
      dp = X.col(4 * term.to + 3) - dp;
    }
    add_up(term);
  }
  return cost;
}

double BlockSolver::cost(const Lifted& targets, const Lifted& X) const {
  return evaluate<Eigen::Dynamic>(&targets, X, nullptr);
}

Lifted BlockSolver::euclidean_gradient(const Lifted& targets, const Lifted& X) const {
  Lifted gradient = Lifted::Zero(X.rows(), X.cols());
  if (rows_in_use(targets) <= 3 && rows_in_use(X) <= 3) {
    const Rows<3> top_targets = targets.topRows<3>();
    Rows<3> top;
    evaluate<3>(&top_targets, X.topRows<3>(), &top);
    gradient.topRows<3>() = top;
  } else {
    evaluate<Eigen::Dynamic>(&targets, X, &gradient);
  }
  return gradient;
}

Lifted BlockSolver::riemannian_gradient(const Lifted& targets, const Lifted& X) const {
  Lifted gradient = euclidean_gradient(targets, X);
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

// To motions of each pose in its own frame, there by H^-1, and back.
template <int R>
void BlockSolver::precondition(const Rows<R>& X, const Rows<R>& V, Rows<R>& result) const {
  Eigen::VectorXd motions(6 * poses_);
  for (int k = 0; k < poses_; ++k) {
    const auto Y = X.template middleCols<3>(4 * k);
    const Eigen::Matrix3d S = Y.transpose().lazyProduct(V.template middleCols<3>(4 * k));
    auto motion = motions.segment<6>(motions_->first_row(k));
    motion.head<3>() = Y.transpose().lazyProduct(V.col(4 * k + 3));
    motion.tail<3>() = 2.0 * vee(S);
  }
  motions = motions_->solve(motions);
  for (int k = 0; k < poses_; ++k) {
    const auto Y = X.template middleCols<3>(4 * k);
    const Vector6d motion = motions.segment<6>(motions_->first_row(k));
    result.col(4 * k + 3) = Y.lazyProduct(motion.head<3>());
    result.template middleCols<3>(4 * k) = Y.lazyProduct(hat(motion.tail<3>()));
  }
  if constexpr (R == Eigen::Dynamic) {
    // What lies outside of the range of each Y.
    const auto normal_part = [&](Rows<R>& U) {
      for (int k = 0; k < poses_; ++k) {
        const Eigen::MatrixXd Y = X.template middleCols<3>(4 * k);
        const Eigen::MatrixXd inside = Y * (Y.transpose() * U.template middleCols<4>(4 * k));
        U.template middleCols<4>(4 * k) -= inside;
      }
    };
    Rows<R> normal = V;
    normal_part(normal);
    Eigen::MatrixXd columns(normal.cols(), normal.rows());
    for (int k = 0; k < poses_; ++k)
      columns.middleRows<4>(normal_->first_row(k)) = normal.template middleCols<4>(4 * k).transpose();
    columns = normal_->solve(columns);
    for (int k = 0; k < poses_; ++k)
      normal.template middleCols<4>(4 * k) = columns.middleRows<4>(normal_->first_row(k)).transpose();
    normal_part(normal);
    result += normal;
  }
}

BlockStep BlockSolver::minimise(const Lifted& targets, Lifted& X) {
  COVEY_CHECK(X.rows() == rank_ && X.cols() == 4 * poses_);
  factorise();
  if (rows_in_use(targets) > 3 || rows_in_use(X) > 3) {
    if (!normal_) factorise_q();
    return descend<Eigen::Dynamic>(targets, X);
  }
  Rows<3> top = X.topRows<3>();
  const BlockStep step = descend<3>(targets.topRows<3>(), top);
  X.topRows<3>() = top;
  return step;
}

template <int R>
BlockStep BlockSolver::descend(const Rows<R>& targets, Rows<R>& X) {
  BlockStep report;
  Rows<R> euclidean;
  double value = evaluate(&targets, X, &euclidean);
  Rows<R> gradient = euclidean;
  project_to_tangent_space(X, gradient);
  report.cost_before = value;
  report.gradient_before = report.gradient_after = gradient.norm();
  const double tolerance =
      std::max(options_.absolute_gradient_tolerance, options_.gradient_tolerance * report.gradient_before);
  double radius = 10.0 * std::sqrt(static_cast<double>(poses_));
  Rows<R> step;
  Rows<R> candidate_euclidean;
  for (int rejected = 0; report.outer < options_.max_outer && report.gradient_after > tolerance;) {
    const double predicted = solve_trust_region(X, euclidean, gradient, radius, step, report.inner);
    if (!(predicted > 1e-15 * value)) break;  // less than the cost can show
    const Rows<R> candidate = retracted(X, step);
    const double candidate_value = evaluate(&targets, candidate, &candidate_euclidean);
    const double ratio = (value - candidate_value) / predicted;
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
    std::swap(euclidean, candidate_euclidean);
    gradient = euclidean;
    project_to_tangent_space(X, gradient);
    report.gradient_after = gradient.norm();
  }
  report.cost_after = value;
  return report;
}

// Steihaug-Toint truncated conjugate gradients on the quadratic model; returns the decrease that the model predicts.
template <int R>
double BlockSolver::solve_trust_region(const Rows<R>& X, const Rows<R>& euclidean, const Rows<R>& gradient,
                                       double radius, Rows<R>& step, int& iterations) const {
  step.setZero(X.rows(), X.cols());
  Rows<R> hessian_step = step;
  Rows<R> residual = gradient;
  Rows<R> preconditioned(X.rows(), X.cols());
  Rows<R> H(X.rows(), X.cols());
  precondition(X, residual, preconditioned);
  Rows<R> direction = -preconditioned;
  double rz = inner_product(residual, preconditioned);
  const double stop = options_.inner_tolerance * options_.inner_tolerance * rz;
  for (int i = 0; i < options_.max_inner; ++i) {
    ++iterations;
    evaluate<R>(nullptr, direction, &H);
    subtract_curvature(X, euclidean, direction, H);
    project_to_tangent_space(X, H);
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
    precondition(X, residual, preconditioned);
    const double next = inner_product(residual, preconditioned);
    if (!(next > stop)) break;
    direction = -preconditioned + (next / rz) * direction;
    rz = next;
  }
  return -inner_product(gradient, step) - 0.5 * inner_product(step, hessian_step);
}

}  // namespace covey::pgo
