// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/marginal.h"

#include <Eigen/Cholesky>
#include <Eigen/CholmodSupport>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/graph/linearise.h"
#include "core/graph/one_thread.h"

namespace covey::graph {
namespace {

constexpr double kRankTolerance = 1e-12;  // of the largest eigenvalue

// The columns of some variables of a system, side by side.
struct Columns {
  std::vector<int> index;

  void append(const std::map<Key, int>& first_column, const Values& values, Key key) {
    for (int c = 0; c < values.type(key).tangent; ++c) index.push_back(first_column.at(key) + c);
  }
};

std::set<Key> of_kind(const std::vector<Key>& keys, char kind) {
  std::set<Key> some;
  if (kind == 0) return some;
  for (const Key key : keys) {
    if (key.kind == kind) some.insert(key);
  }
  return some;
}

int total_tangent(const std::vector<VariableType>& types) {
  int sum = 0;
  for (const VariableType type : types) sum += type.tangent;
  return sum;
}

std::vector<VariableType> types_of(const std::vector<Key>& keys, const Values& values) {
  std::vector<VariableType> types;
  for (const Key key : keys) types.push_back(values.type(key));
  return types;
}

struct SquareRoot {
  Eigen::MatrixXd A;
  Eigen::VectorXd c;
  Eigen::MatrixXd spread;
};

// A^T A = H, A^T c = b, A^T spread A = M, as many rows as H has eigenvalues that count.
SquareRoot square_root(const Eigen::MatrixXd& H, const Eigen::VectorXd& b, const Eigen::MatrixXd& M) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H);
  const double floor = kRankTolerance * std::max(eigen.eigenvalues().maxCoeff(), 0.0);
  const Eigen::Index rank = (eigen.eigenvalues().array() > floor).count();
  const Eigen::MatrixXd V = eigen.eigenvectors().rightCols(rank);
  const Eigen::VectorXd roots = eigen.eigenvalues().tail(rank).cwiseSqrt();
  const Eigen::MatrixXd W = V * roots.cwiseInverse().asDiagonal();
  return {roots.asDiagonal() * V.transpose(), W.transpose() * b, W.transpose() * M * W};
}

// From perturbations of the values, of which root is a function, to differences from the points of the held variables, d_0 = minus(x, x_0) + M d
// (linearisation_point.h). Returns the points.
Values move_to_points(const Graph& graph, const Values& values, const std::vector<Key>& keys,
                      SquareRoot& root) {
  Values points;
  Eigen::Index column = 0;
  for (const Key key : keys) {
    const VariableType type = values.type(key);
    const bool held = graph.held().has(key);
    points.copy(key, held ? graph.held() : values);
    if (held) {
      const double* x = values.data(key);
      const double* x_0 = points.data(key);
      auto A = root.A.middleCols(column, type.tangent);
      if (type.space != Space::kVector) A = (A * minus_jacobian(type, x, x_0).inverse()).eval();
      Eigen::VectorXd difference(type.tangent);
      minus(type, x, x_0, difference.data());
      root.c -= A * difference;
    }
    column += type.tangent;
  }
  return points;
}

Graph factors_touching(const Graph& graph, const std::vector<Key>& keys) {
  Graph part;
  for (const FactorId id : graph.ids_touching(keys)) {
    part.add(graph.shared_factor(id), graph.robust(id));
    for (const Key key : graph.factor(id).keys()) {
      if (graph.is_constant(key)) part.set_constant(key);
      if (graph.held().has(key)) part.hold(key, graph.held());
    }
  }
  return part;
}

}  // namespace

LinearPrior::LinearPrior(const std::vector<Key>& keys, const Values& values, Eigen::MatrixXd A,
                         Eigen::VectorXd c, Eigen::MatrixXd spread)
    : Factor(keys, types_of(keys, values), static_cast<int>(A.rows())),
      A_(std::move(A)),
      c_(std::move(c)),
      spread_(std::move(spread)) {
  COVEY_CHECK(A_.rows() == c_.size() && A_.cols() == total_tangent(types()));
  COVEY_CHECK(spread_.rows() == c_.size() && spread_.cols() == c_.size());
  for (const Key key : keys) {
    x0_.emplace_back();
    std::copy_n(values.data(key), values.type(key).ambient, x0_.back().begin());
  }
}

void LinearPrior::evaluate(const double* const* x, double* residual, double* const* jacobians) const {
  Eigen::Map<Eigen::VectorXd> r(residual, residual_dim());
  r = c_;
  int column = 0;
  for (std::size_t k = 0; k < x0_.size(); ++k) {
    const VariableType type = types()[k];
    const auto block = A_.middleCols(column, type.tangent);
    std::array<double, kMaxAmbient> delta;
    minus(type, x[k], x0_[k].data(), delta.data());
    r.noalias() += block * Eigen::Map<const Eigen::VectorXd>(delta.data(), type.tangent);
    if (jacobians && jacobians[k]) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J(
          jacobians[k], residual_dim(), type.tangent);
      if (type.space == Space::kVector) {
        J = block;
      } else {
        J.noalias() = block * minus_jacobian(type, x[k], x0_[k].data());
      }
    }
    column += type.tangent;
  }
}

std::shared_ptr<const LinearPrior> marginalise(const Graph& graph, const Values& values,
                                               const std::vector<Key>& removed, char eliminate_first,
                                               const SharedError& shared) {
  const Graph part = factors_touching(graph, removed);
  for (const Key key : removed) COVEY_CHECK(!graph.is_constant(key));
  const ReducedSystem system = reduce(part, values, of_kind(removed, eliminate_first), shared);
  Columns m;
  Columns k;
  std::vector<Key> kept;
  for (const auto& [key, column] : system.first_column) {
    if (std::find(removed.begin(), removed.end(), key) != removed.end()) {
      m.append(system.first_column, values, key);
    } else {
      k.append(system.first_column, values, key);
      kept.push_back(key);
    }
  }
  if (kept.empty()) return nullptr;

  const Eigen::MatrixXd H_mk = system.H(m.index, k.index);
  const Eigen::MatrixXd H_km_inverse = solve_semidefinite(system.H(m.index, m.index), H_mk).transpose();
  const Eigen::MatrixXd H_p = system.H(k.index, k.index) - H_km_inverse * H_mk;
  const Eigen::VectorXd b_p = system.b(k.index) - H_km_inverse * system.b(m.index);
  const Eigen::MatrixXd Mc = system.M(k.index, m.index);
  const Eigen::MatrixXd Mp = system.M(k.index, k.index) - H_km_inverse * Mc.transpose() -
                             Mc * H_km_inverse.transpose() +
                             H_km_inverse * system.M(m.index, m.index) * H_km_inverse.transpose();
  SquareRoot root = square_root(0.5 * (H_p + H_p.transpose()), b_p, 0.5 * (Mp + Mp.transpose()));
  if (root.A.rows() == 0) return nullptr;
  const Values points = move_to_points(graph, values, kept, root);
  return std::make_shared<LinearPrior>(kept, points, std::move(root.A), std::move(root.c),
                                       std::move(root.spread));
}

std::optional<FactorId> marginalise_out(Graph& graph, Values& values, const std::vector<Key>& removed,
                                        char eliminate_first, const SharedError& shared) {
  const auto prior = marginalise(graph, values, removed, eliminate_first, shared);
  for (const FactorId id : graph.ids_touching(removed)) graph.remove(id);
  for (const Key key : removed) {
    values.erase(key);
    graph.release(key);
  }
  if (!prior) return std::nullopt;
  return graph.add(prior);
}

std::optional<Eigen::MatrixXd> marginal_covariance(const Graph& graph, const Values& values,
                                                   const std::vector<Key>& keys) {
  const Linearisation model = linearise(graph, values);
  Columns wanted;
  for (const Key key : keys) {
    COVEY_CHECK(model.first_column.contains(key));
    wanted.append(model.first_column, values, key);
  }
  const Eigen::SparseMatrix<double> H = model.J.transpose() * model.J;
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> cholesky;
  cholesky.cholmod().print = 0;
  const OneThread one_thread;
  cholesky.compute(H);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(H.rows(), static_cast<Eigen::Index>(wanted.index.size()));
  for (std::size_t c = 0; c < wanted.index.size(); ++c)
    unit(wanted.index[c], static_cast<Eigen::Index>(c)) = 1.0;
  const Eigen::MatrixXd solution = cholesky.solve(unit);
  const Eigen::MatrixXd covariance = solution(wanted.index, Eigen::all);
  // Without gauge rounding can still let the factorisation pass. Then the variances are far above what the
  // factors at the variable itself allow.
  const Eigen::VectorXd information = H.diagonal();
  const Eigen::VectorXd inflation = covariance.diagonal().cwiseProduct(information(wanted.index));
  if (!covariance.allFinite() || inflation.maxCoeff() * kRankTolerance > 1.0) return std::nullopt;
  return 0.5 * (covariance + covariance.transpose());
}

DenseMarginals::DenseMarginals(const Graph& graph, const Values& values, char eliminate_first,
                               const SharedError& shared) {
  const ReducedSystem system = reduce(graph, values, of_kind(graph.keys(), eliminate_first), shared);
  for (const auto& [key, column] : system.first_column) columns_[key] = {column, values.type(key).tangent};
  // Unknowns in units of what their own factors allow: then the diagonal of the inverse says how much worse they are known.
  scale_ = system.H.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
  cholesky_.compute(scale_.asDiagonal() * system.H * scale_.asDiagonal());
  M_ = scale_.asDiagonal() * system.M * scale_.asDiagonal();
}

std::optional<Eigen::MatrixXd> DenseMarginals::covariance(const std::vector<Key>& keys) const {
  std::vector<int> wanted;
  for (const Key key : keys) {
    COVEY_CHECK(columns_.contains(key));
    const Columns& columns = columns_.at(key);
    for (int c = 0; c < columns.count; ++c) wanted.push_back(columns.first + c);
  }
  if (cholesky_.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(scale_.size(), static_cast<Eigen::Index>(wanted.size()));
  for (std::size_t c = 0; c < wanted.size(); ++c) inverse(wanted[c], static_cast<Eigen::Index>(c)) = 1.0;
  cholesky_.solveInPlace(inverse);
  for (std::size_t c = 0; c < wanted.size(); ++c) {
    const double known = inverse(wanted[c], static_cast<Eigen::Index>(c)) * kRankTolerance;
    if (!(known < 1.0)) return std::nullopt;
  }
  Eigen::MatrixXd scaled = inverse.transpose() * M_ * inverse;
  scaled = 0.5 * (scaled + scaled.transpose()).eval();
  if (!scaled.allFinite()) return std::nullopt;
  const Eigen::VectorXd scale = scale_(wanted);
  return scale.asDiagonal() * scaled * scale.asDiagonal();
}

}  // namespace covey::graph
