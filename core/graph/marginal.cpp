// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/marginal.h"

#include <Eigen/CholmodSupport>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/graph/linearise.h"

namespace covey::graph {
namespace {

constexpr double kRankTolerance = 1e-12;  // of the largest eigenvalue

// The columns of some variables of a linearisation, side by side.
struct Columns {
  std::vector<int> index;

  void append(const Linearisation& model, const Values& values, Key key) {
    for (int c = 0; c < values.type(key).tangent; ++c) index.push_back(model.first_column.at(key) + c);
  }
};

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

// H^-1 B; by Cholesky after scaling to a unit diagonal, and by eigenvalues where that finds directions
// without information.
Eigen::MatrixXd solve_semidefinite(const Eigen::MatrixXd& H, const Eigen::MatrixXd& B) {
  const Eigen::VectorXd scale =
      H.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 0.0; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(scaled);
  if (ldlt.info() == Eigen::Success && ldlt.vectorD().minCoeff() > kRankTolerance) {
    return scale.asDiagonal() * ldlt.solve(scale.asDiagonal() * B);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  const double floor = kRankTolerance * std::max(eigen.eigenvalues().maxCoeff(), 0.0);
  const Eigen::VectorXd inverse =
      eigen.eigenvalues().unaryExpr([&](double value) { return value > floor ? 1.0 / value : 0.0; });
  const Eigen::MatrixXd projected = eigen.eigenvectors().transpose() * (scale.asDiagonal() * B);
  return scale.asDiagonal() * (eigen.eigenvectors() * (inverse.asDiagonal() * projected));
}

struct SquareRoot {
  Eigen::MatrixXd A;
  Eigen::VectorXd c;
};

// A^T A = H, A^T c = b, as many rows as H has eigenvalues that count.
SquareRoot square_root(const Eigen::MatrixXd& H, const Eigen::VectorXd& b) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H);
  const double floor = kRankTolerance * std::max(eigen.eigenvalues().maxCoeff(), 0.0);
  const Eigen::Index rank = (eigen.eigenvalues().array() > floor).count();
  const Eigen::MatrixXd V = eigen.eigenvectors().rightCols(rank);
  const Eigen::VectorXd roots = eigen.eigenvalues().tail(rank).cwiseSqrt();
  return {roots.asDiagonal() * V.transpose(), roots.cwiseInverse().asDiagonal() * (V.transpose() * b)};
}

Graph factors_touching(const Graph& graph, const std::vector<Key>& keys) {
  Graph part;
  for (const FactorId id : graph.ids_touching(keys)) {
    part.add(graph.shared_factor(id), graph.robust(id));
    for (const Key key : graph.factor(id).keys()) {
      if (graph.is_constant(key)) part.set_constant(key);
    }
  }
  return part;
}

}  // namespace

LinearPrior::LinearPrior(const std::vector<Key>& keys, const Values& values, Eigen::MatrixXd A,
                         Eigen::VectorXd c)
    : Factor(keys, types_of(keys, values), static_cast<int>(A.rows())), A_(std::move(A)), c_(std::move(c)) {
  COVEY_CHECK(A_.rows() == c_.size() && A_.cols() == total_tangent(types()));
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
                                               const std::vector<Key>& removed) {
  const Graph part = factors_touching(graph, removed);
  const Linearisation model = linearise(part, values);
  Columns m;
  Columns k;
  std::vector<Key> kept;
  for (const auto& [key, column] : model.first_column) {
    if (std::find(removed.begin(), removed.end(), key) != removed.end()) {
      m.append(model, values, key);
    } else {
      k.append(model, values, key);
      kept.push_back(key);
    }
  }
  for (const Key key : removed) COVEY_CHECK(!graph.is_constant(key));
  if (kept.empty()) return nullptr;

  const Eigen::MatrixXd H = Eigen::MatrixXd(Eigen::SparseMatrix<double>(model.J.transpose() * model.J));
  const Eigen::VectorXd b = model.J.transpose() * model.r;
  const Eigen::MatrixXd H_mk = H(m.index, k.index);
  const Eigen::MatrixXd H_km_inverse = solve_semidefinite(H(m.index, m.index), H_mk).transpose();
  const Eigen::MatrixXd H_p = H(k.index, k.index) - H_km_inverse * H_mk;
  const Eigen::VectorXd b_p = b(k.index) - H_km_inverse * b(m.index);
  SquareRoot root = square_root(0.5 * (H_p + H_p.transpose()), b_p);
  if (root.A.rows() == 0) return nullptr;
  return std::make_shared<LinearPrior>(kept, values, std::move(root.A), std::move(root.c));
}

std::optional<FactorId> marginalise_out(Graph& graph, Values& values, const std::vector<Key>& removed) {
  const auto prior = marginalise(graph, values, removed);
  for (const FactorId id : graph.ids_touching(removed)) graph.remove(id);
  for (const Key key : removed) values.erase(key);
  if (!prior) return std::nullopt;
  return graph.add(prior);
}

std::optional<Eigen::MatrixXd> marginal_covariance(const Graph& graph, const Values& values,
                                                   const std::vector<Key>& keys) {
  const Linearisation model = linearise(graph, values);
  Columns wanted;
  for (const Key key : keys) {
    COVEY_CHECK(model.first_column.contains(key));
    wanted.append(model, values, key);
  }
  const Eigen::SparseMatrix<double> H = model.J.transpose() * model.J;
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> cholesky;
  cholesky.cholmod().print = 0;
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

}  // namespace covey::graph
