// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/reduced.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <span>

#include "core/graph/linearisation_point.h"

namespace covey::graph {
namespace {

constexpr double kRankTolerance = 1e-12;  // of the largest eigenvalue

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using RowMajorMap = Eigen::Map<const RowMajorMatrix>;
using Block =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxAmbient, kMaxAmbient>;

// J_i^T J_j, without the detour of a general product where there are few rows.
template <typename Target>
void add_product(const RowMajorMap& J_i, const RowMajorMap& J_j, Target&& target) {
  constexpr Eigen::Index kFew = 12;
  if (J_i.rows() <= kFew) {
    target += J_i.transpose().lazyProduct(J_j);
  } else {
    target.noalias() += J_i.transpose() * J_j;
  }
}

// One factor at the values, with its kernel's weight, in memory that is used again for the next one.
class LinearFactor {
 public:
  void evaluate(const Graph& graph, FactorId id, const Values& values) {
    const Factor& factor = graph.factor(id);
    const std::size_t count = factor.keys().size();
    rows_ = factor.residual_dim();
    x_.resize(count);
    jacobians_.resize(count);
    columns_.resize(count);
    std::size_t doubles = static_cast<std::size_t>(rows_);
    for (std::size_t k = 0; k < count; ++k) {
      COVEY_CHECK(values.type(factor.keys()[k]) == factor.types()[k]);
      x_[k] = values.data(factor.keys()[k]);
      columns_[k] = factor.types()[k].tangent;
      doubles += static_cast<std::size_t>(rows_ * columns_[k]);
    }
    memory_.resize(doubles);
    double* free = memory_.data() + rows_;
    for (std::size_t k = 0; k < count; ++k) {
      jacobians_[k] = free;
      free += rows_ * columns_[k];
    }
    LinearisationPoint(graph, factor).evaluate(x_.data(), memory_.data(), jacobians_.data());
    const double scale = std::sqrt(graph.robust(id).derivative(r().squaredNorm()));
    if (scale != 1.0)
      Eigen::Map<Eigen::VectorXd>(memory_.data(), static_cast<Eigen::Index>(doubles)) *= scale;
  }
  Eigen::Map<const Eigen::VectorXd> r() const { return {memory_.data(), rows_}; }
  RowMajorMap jacobian(std::size_t k) const { return {jacobians_[k], rows_, columns_[k]}; }
  std::span<const double> memory() const { return memory_; }

 private:
  int rows_ = 0;
  std::vector<const double*> x_;
  std::vector<double*> jacobians_;
  std::vector<int> columns_;
  std::vector<double> memory_;  // residual, then Jacobians
};

constexpr int kNoColumn = -1;

struct Place {
  std::size_t centre;  // which of the factor's variables is eliminated; the number of variables where none is
  std::vector<int> columns;  // kNoColumn: constant or eliminated
};

Place place(const Factor& factor, const ReducedSystem& system, const std::set<Key>& eliminated) {
  Place place{factor.keys().size(), {}};
  for (std::size_t k = 0; k < factor.keys().size(); ++k) {
    const auto column = system.first_column.find(factor.keys()[k]);
    place.columns.push_back(column == system.first_column.end() ? kNoColumn : column->second);
    if (!eliminated.contains(factor.keys()[k])) continue;
    COVEY_CHECK(place.centre == factor.keys().size());
    place.centre = k;
  }
  return place;
}

// A block and the one across the diagonal; of one variable with itself both in one place.
void add_symmetric(const Block& block, int row, int column, Eigen::MatrixXd& M) {
  M.block(row, column, block.rows(), block.cols()) += block;
  M.block(column, row, block.cols(), block.rows()) += block.transpose();
}

// The factors that share one eliminated variable e, and what its elimination leaves on the others. A factor i has the residual r_i, the Jacobians E_i of e and
// Q_ik of another variable k, and c_ij I = E[r_i r_j^T]. With U_k = H_ee^-1 sum_i E_i^T Q_ik the gradient of k that is left is
//
//   g_k = sum_i Q_ik^T r_i - U_k^T sum_j E_j^T r_j
//   E[g_k g_l^T] = sum_ij c_ij Q_ik^T Q_jl - W_k U_l - (W_l U_k)^T
//   W_k = sum_i Q_ik^T F_i - U_k^T S / 2,   F_i = sum_j c_ij E_j,   S = sum_j E_j^T F_j
class Star {
 public:
  void add(const LinearFactor& linear, const Factor& factor, Place at) {
    const int rows = factor.residual_dim();
    views_.push_back({&factor, std::move(at), memory_.size(), rows_});
    memory_.insert(memory_.end(), linear.memory().begin(), linear.memory().end());
    rows_ += rows;
  }

  void eliminate(const SharedError& shared, ReducedSystem& system) const {
    const Eigen::Index dim = views_.front().factor->types()[views_.front().at.centre].tangent;
    RowMajorMatrix E(rows_, dim);
    Eigen::VectorXd r(rows_);
    for (const View& view : views_) {
      E.middleRows(view.row, view.rows()) = jacobian(view, view.at.centre);
      r.segment(view.row, view.rows()) = residual(view);
    }
    RowMajorMatrix F = shared.variance * E;
    for (std::size_t j = 0; j < views_.size(); ++j)
      add_products(views_[j], views_[j], shared.variance, system.M);
    for (std::size_t j = 0; j < views_.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        const double c = covariance(shared, views_[i], views_[j]);
        if (c == 0.0) continue;
        F.middleRows(views_[i].row, views_[i].rows()) += c * E.middleRows(views_[j].row, views_[j].rows());
        F.middleRows(views_[j].row, views_[j].rows()) += c * E.middleRows(views_[i].row, views_[i].rows());
        add_products(views_[i], views_[j], c, system.M);
      }
    }
    const Block H_ee = E.transpose().lazyProduct(E);
    const Block inverse = solve_semidefinite(H_ee, Eigen::MatrixXd::Identity(dim, dim));
    const Block x = inverse.lazyProduct(Block(E.transpose().lazyProduct(r)));
    const Block S = E.transpose().lazyProduct(F);
    std::vector<Arm> arms = arms_of(F, dim);
    for (Arm& arm : arms) {
      arm.U = inverse.lazyProduct(arm.H_ek);
      arm.W -= 0.5 * arm.U.transpose().lazyProduct(S);
    }
    for (std::size_t l = 0; l < arms.size(); ++l) {
      const Arm& L = arms[l];
      system.b.segment(L.column, L.U.cols()) -= L.H_ek.transpose().lazyProduct(x);
      for (std::size_t k = 0; k <= l; ++k) {
        const Arm& K = arms[k];
        const double share = k == l ? 0.5 : 1.0;  // the diagonal's block comes twice
        add_symmetric(-share * K.H_ek.transpose().lazyProduct(L.U), K.column, L.column, system.H);
        add_symmetric(-share * (K.W.lazyProduct(L.U) + L.W.lazyProduct(K.U).transpose()), K.column, L.column,
                      system.M);
      }
    }
  }

 private:
  struct View {
    const Factor* factor;
    Place at;
    std::size_t first;  // in memory_: residual and Jacobians
    Eigen::Index row;
    int rows() const { return factor->residual_dim(); }
  };
  struct Arm {
    int column;
    Block H_ek;
    Block U;
    Block W;
  };

  Eigen::Map<const Eigen::VectorXd> residual(const View& view) const {
    return {memory_.data() + view.first, view.rows()};
  }
  RowMajorMap jacobian(const View& view, std::size_t k) const {
    const std::vector<VariableType>& types = view.factor->types();
    std::size_t first = view.first + static_cast<std::size_t>(view.rows());
    for (std::size_t before = 0; before < k; ++before)
      first += static_cast<std::size_t>(view.rows() * types[before].tangent);
    return {memory_.data() + first, view.rows(), types[k].tangent};
  }

  static double covariance(const SharedError& shared, const View& i, const View& j) {
    const Occasion* a = i.factor->occasion();
    const Occasion* b = j.factor->occasion();
    if (!a || !b || a->series != b->series || shared.share == 0.0) return 0.0;
    return shared.variance * shared.share * std::exp(-std::abs(a->time_s - b->time_s) / shared.memory_s);
  }

  // c Q_i^T Q_j of all their variables but e, and where i is not j the same across the diagonal.
  void add_products(const View& i, const View& j, double c, Eigen::MatrixXd& M) const {
    for (std::size_t k = 0; k < i.at.columns.size(); ++k) {
      if (i.at.columns[k] == kNoColumn) continue;
      const RowMajorMap Q_k = jacobian(i, k);
      for (std::size_t l = 0; l < j.at.columns.size(); ++l) {
        if (j.at.columns[l] == kNoColumn) continue;
        const RowMajorMap Q_l = jacobian(j, l);
        const Block product = c * Q_k.transpose().lazyProduct(Q_l);
        if (&i != &j) {
          add_symmetric(product, i.at.columns[k], j.at.columns[l], M);
        } else {
          M.block(i.at.columns[k], j.at.columns[l], product.rows(), product.cols()) += product;
        }
      }
    }
  }

  // H_ek, and of W what F says.
  std::vector<Arm> arms_of(const RowMajorMatrix& F, Eigen::Index dim) const {
    std::vector<Arm> arms;
    for (const View& view : views_) {
      const RowMajorMap E = jacobian(view, view.at.centre);
      for (std::size_t k = 0; k < view.at.columns.size(); ++k) {
        const int column = view.at.columns[k];
        if (column == kNoColumn) continue;
        const RowMajorMap Q = jacobian(view, k);
        auto arm = std::find_if(arms.begin(), arms.end(), [&](const Arm& a) { return a.column == column; });
        if (arm == arms.end())
          arm = arms.insert(arm, {column, Block::Zero(dim, Q.cols()), Block(), Block::Zero(Q.cols(), dim)});
        arm->H_ek += E.transpose().lazyProduct(Q);
        arm->W += Q.transpose().lazyProduct(F.middleRows(view.row, view.rows()));
      }
    }
    return arms;
  }

  std::vector<double> memory_;
  std::vector<View> views_;
  Eigen::Index rows_ = 0;
};

void add_to_system(const LinearFactor& factor, const Place& place, Eigen::MatrixXd& H, Eigen::VectorXd& b) {
  for (std::size_t i = 0; i < place.columns.size(); ++i) {
    if (place.columns[i] == kNoColumn) continue;
    b.segment(place.columns[i], factor.jacobian(i).cols()).noalias() +=
        factor.jacobian(i).transpose() * factor.r();
    for (std::size_t j = 0; j < place.columns.size(); ++j) {
      if (place.columns[j] == kNoColumn) continue;
      add_product(
          factor.jacobian(i), factor.jacobian(j),
          H.block(place.columns[i], place.columns[j], factor.jacobian(i).cols(), factor.jacobian(j).cols()));
    }
  }
}

// What M has beyond H.
void add_spread(const LinearFactor& factor, const Place& place, const Eigen::MatrixXd& spread,
                Eigen::MatrixXd& M) {
  const Eigen::MatrixXd beyond = spread - Eigen::MatrixXd::Identity(spread.rows(), spread.cols());
  for (std::size_t j = 0; j < place.columns.size(); ++j) {
    if (place.columns[j] == kNoColumn) continue;
    const Eigen::MatrixXd spread_j = beyond * factor.jacobian(j);
    for (std::size_t i = 0; i < place.columns.size(); ++i) {
      if (place.columns[i] == kNoColumn) continue;
      M.block(place.columns[i], place.columns[j], factor.jacobian(i).cols(), spread_j.cols()).noalias() +=
          factor.jacobian(i).transpose() * spread_j;
    }
  }
}

// H is so far what factors of eliminated variables say.
void add_common(const SharedError& shared, ReducedSystem& system) {
  if (shared.common.empty()) return;
  Eigen::MatrixXd gradient = Eigen::MatrixXd::Zero(system.H.rows(), shared.common.begin()->second.cols());
  for (const auto& [key, displacement] : shared.common) {
    const auto column = system.first_column.find(key);
    if (column != system.first_column.end())
      gradient += system.H.middleCols(column->second, displacement.rows()) * displacement;
  }
  system.M += gradient * gradient.transpose();
}

}  // namespace

ReducedSystem reduce(const Graph& graph, const Values& values, const std::set<Key>& eliminated,
                     const SharedError& shared) {
  ReducedSystem system;
  int columns = 0;
  for (const Key key : graph.keys()) {
    if (graph.is_constant(key) || eliminated.contains(key)) continue;
    system.first_column[key] = columns;
    columns += values.type(key).tangent;
  }
  system.H = Eigen::MatrixXd::Zero(columns, columns);
  system.b = Eigen::VectorXd::Zero(columns);
  // Of the factors without an eliminated variable; in the end M has what all of them would add were their residuals' covariances I.
  Eigen::MatrixXd rest = system.H;
  system.M = system.H;
  std::map<Key, Star> stars;
  LinearFactor linear;
  for (const FactorId id : graph.ids()) {
    const Factor& factor = graph.factor(id);
    const Place at = place(factor, system, eliminated);
    linear.evaluate(graph, id, values);
    if (at.centre == factor.keys().size()) {
      add_to_system(linear, at, rest, system.b);
      if (factor.spread()) add_spread(linear, at, *factor.spread(), system.M);
      continue;
    }
    add_to_system(linear, at, system.H, system.b);
    stars[factor.keys()[at.centre]].add(linear, factor, at);
  }
  for (const auto& [key, star] : stars) star.eliminate(shared, system);
  add_common(shared, system);
  system.M += rest;
  system.H += rest;
  return system;
}

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

}  // namespace covey::graph
