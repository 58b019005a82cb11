// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/reduced.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

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
    if (memory_.size() < doubles) memory_.resize(doubles);
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

 private:
  int rows_ = 0;
  std::vector<const double*> x_;
  std::vector<double*> jacobians_;
  std::vector<int> columns_;
  std::vector<double> memory_;
};

// The factors that share one eliminated variable, and what its elimination leaves on the others.
class Star {
 public:
  explicit Star(int dim) : H_ee_(Block::Zero(dim, dim)), b_e_(Block::Zero(dim, 1)) {}

  void add_centre(const LinearFactor& factor, std::size_t centre) {
    add_product(factor.jacobian(centre), factor.jacobian(centre), H_ee_);
    b_e_ += factor.jacobian(centre).transpose().lazyProduct(factor.r());
  }
  void add_arm(const LinearFactor& factor, std::size_t centre, std::size_t k, int column) {
    auto arm = std::find_if(arms_.begin(), arms_.end(), [&](const Arm& a) { return a.column == column; });
    if (arm == arms_.end()) {
      arms_.push_back({column, Block::Zero(H_ee_.rows(), factor.jacobian(k).cols())});
      arm = std::prev(arms_.end());
    }
    add_product(factor.jacobian(centre), factor.jacobian(k), arm->H_ek);
  }
  void eliminate(ReducedSystem& system) const {
    const Block inverse = solve_semidefinite(H_ee_, Eigen::MatrixXd::Identity(H_ee_.rows(), H_ee_.rows()));
    for (const Arm& j : arms_) {
      const Block X = inverse.lazyProduct(j.H_ek);
      system.b.segment(j.column, j.H_ek.cols()) -= X.transpose().lazyProduct(b_e_);
      for (const Arm& i : arms_) {
        system.H.block(i.column, j.column, i.H_ek.cols(), j.H_ek.cols()) -= i.H_ek.transpose().lazyProduct(X);
      }
    }
  }

 private:
  struct Arm {
    int column;
    Block H_ek;
  };
  Block H_ee_;
  Block b_e_;
  std::vector<Arm> arms_;
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

}  // namespace

ReducedSystem reduce(const Graph& graph, const Values& values, const std::set<Key>& eliminated,
                     double overcount) {
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
    Star& star = stars.try_emplace(factor.keys()[at.centre], factor.types()[at.centre].tangent).first->second;
    star.add_centre(linear, at.centre);
    for (std::size_t k = 0; k < at.columns.size(); ++k) {
      if (at.columns[k] != kNoColumn) star.add_arm(linear, at.centre, k, at.columns[k]);
    }
  }
  for (const auto& [key, star] : stars) star.eliminate(system);
  system.M += rest + overcount * system.H;
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
