// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/sparse_problem.h"

#include <algorithm>
#include <cmath>

namespace covey::graph {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kSmallestScale = 1e-6;    // of damping, where a variable has no information
constexpr double kLeastGain = 1e-3;        // of what the model promises, for a step to be taken
constexpr double kSmallestRadius = 1e-32;  // below which no step lowers the cost
constexpr double kRounding = 1e-12;        // a step below this part of the state is lost in it

// The damping of Levenberg-Marquardt is 1 / radius. Source: Madsen, Nielsen, Tingleff, "Methods for Non-Linear Least Squares
// Problems", 2004, section 3.2.
struct TrustRegion {
  double radius;
  double shrink = 2.0;

  void grow(double gain_ratio) {
    radius /= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain_ratio - 1.0, 3));
    shrink = 2.0;
  }
  void reject() {
    radius /= shrink;
    shrink *= 2.0;
  }
};

// target += J_row^T J_column, both row-major of `rows` rows.
template <int kRows, int kRow, int kColumn>
void add_product(const double* J_row, const double* J_column, int rows, int row_size, int column_size,
                 double* target, Eigen::Index stride) {
  using Row = Eigen::Matrix<double, kRows, kRow, Eigen::RowMajor>;
  using Column = Eigen::Matrix<double, kRows, kColumn, Eigen::RowMajor>;
  using Target = Eigen::Matrix<double, kRow, kColumn>;
  Eigen::Map<Target, 0, Eigen::OuterStride<>>(target, row_size, column_size, Eigen::OuterStride<>(stride)) +=
      Eigen::Map<const Row>(J_row, rows, row_size)
          .transpose()
          .lazyProduct(Eigen::Map<const Column>(J_column, rows, column_size));
}

// The sizes of pose graphs are known to the compiler, the others are not.
void add_product(const double* J_row, const double* J_column, int rows, int row_size, int column_size,
                 double* target, Eigen::Index stride) {
  if (rows == 6 && row_size == 6 && column_size == 6) {
    add_product<6, 6, 6>(J_row, J_column, rows, row_size, column_size, target, stride);
  } else if (rows == 3 && row_size == 3 && column_size == 3) {
    add_product<3, 3, 3>(J_row, J_column, rows, row_size, column_size, target, stride);
  } else {
    add_product<Eigen::Dynamic, Eigen::Dynamic, Eigen::Dynamic>(J_row, J_column, rows, row_size, column_size,
                                                                target, stride);
  }
}

}  // namespace

SparseProblem::SparseProblem(const Graph& graph, Values& values) {
  const std::vector<Key> keys = graph.keys();
  int blocks = 0;
  for (const Key key : keys) {
    variables_.push_back({values.data(key), values.type(key), graph.is_constant(key) ? kConstant : blocks++});
  }
  int most_doubles = 0;
  int most_rows = 0;
  std::size_t most_variables = 0;
  for (const FactorId id : graph.ids()) {
    terms_.resize(id + 1);
    Term& term = terms_[id];
    term.factor = &graph.factor(id);
    term.robust = graph.robust(id);
    int tangent = 0;
    for (std::size_t k = 0; k < term.factor->keys().size(); ++k) {
      const auto found = std::lower_bound(keys.begin(), keys.end(), term.factor->keys()[k]);
      term.variables.push_back(static_cast<int>(found - keys.begin()));
      COVEY_CHECK(variables_[term.variables.back()].type == term.factor->types()[k]);
      tangent += term.factor->types()[k].tangent;
    }
    most_rows = std::max(most_rows, term.factor->residual_dim());
    most_doubles = std::max(most_doubles, term.factor->residual_dim() * tangent);
    most_variables = std::max(most_variables, term.variables.size());
  }
  x_.resize(most_variables);
  jacobians_.resize(most_variables);
  r_.resize(most_rows);
  J_.resize(most_doubles);
}

double SparseProblem::squared_residual(FactorId id) {
  const Term& term = terms_[id];
  for (std::size_t k = 0; k < term.variables.size(); ++k) x_[k] = variables_[term.variables[k]].home;
  term.factor->evaluate(x_.data(), r_.data(), nullptr);
  return Eigen::Map<const Eigen::VectorXd>(r_.data(), term.factor->residual_dim()).squaredNorm();
}

SolveResult SparseProblem::solve(const SolveOptions& options) {
  State x = state();
  SolveResult result;
  result.initial_cost = result.final_cost = cost(x);
  if (!std::isfinite(result.initial_cost)) {
    result.message = "The cost at the start is not finite.";
    return result;
  }
  if (!pattern_fits()) lay_out();
  TrustRegion region{options.initial_trust_radius};
  result.message = "All iterations were used.";
  bool linear_here = false;
  while (result.iterations < options.max_iterations) {
    if (options.each_step) options.each_step();
    if (!linear_here) linearise(x);
    linear_here = true;
    if (gradient_.size() == 0 || gradient_.lpNorm<Eigen::Infinity>() <= options.gradient_tolerance) {
      result.converged = true;
      result.message = "The gradient is zero.";
      break;
    }
    const std::optional<Step> step = step_from(x, region.radius);
    ++result.iterations;
    const double enough = options.relative_cost_tolerance * result.final_cost;
    const double gain = step ? result.final_cost - step->cost : 0.0;
    const bool taken = step && gain > kLeastGain * step->promised;
    result.converged = step && (step->promised <= enough || (taken && (gain <= enough || step->is_rounding)));
    if (taken) {
      x = step->to;
      result.final_cost = step->cost;
      region.grow(gain / step->promised);
      linear_here = false;
    } else {
      region.reject();
    }
    if (result.converged) {
      result.message = "A step lowers the cost by less than the tolerance.";
      break;
    }
    if (region.radius < kSmallestRadius) {
      result.message = "No step lowers the cost.";
      break;
    }
  }
  store(x);
  return result;
}

std::optional<SparseProblem::Step> SparseProblem::step_from(const State& x, double radius) {
  const Eigen::VectorXd scale = system_->H.diagonal().cwiseMax(kSmallestScale);
  const auto d = system_->solve(-gradient_, scale / radius);
  if (!d) return std::nullopt;
  Step step;
  step.promised = -2.0 * gradient_.dot(*d) - d->dot(system_->H.times(*d));
  if (!(step.promised > 0.0)) return std::nullopt;
  step.to = x;
  for (std::size_t v = 0; v < variables_.size(); ++v) {
    if (variables_[v].block == kConstant) continue;
    double* x_v = step.to.data() + v * kMaxAmbient;
    plus(variables_[v].type, x_v, d->data() + system_->H.first_row(variables_[v].block), x_v);
  }
  step.cost = cost(step.to);
  step.is_rounding =
      d->squaredNorm() <=
      kRounding * kRounding * Eigen::Map<const Eigen::VectorXd>(x.data(), std::ssize(x)).squaredNorm();
  return step;
}

SparseProblem::State SparseProblem::state() const {
  State x(variables_.size() * kMaxAmbient, 0.0);
  for (std::size_t v = 0; v < variables_.size(); ++v)
    std::copy_n(variables_[v].home, variables_[v].type.ambient, x.data() + v * kMaxAmbient);
  return x;
}

void SparseProblem::store(const State& x) {
  for (std::size_t v = 0; v < variables_.size(); ++v) {
    if (variables_[v].block == kConstant) continue;
    std::copy_n(x.data() + v * kMaxAmbient, variables_[v].type.ambient, variables_[v].home);
  }
}

bool SparseProblem::pattern_fits() const {
  if (!system_) return false;
  bool has_spare = false;
  for (const Term& term : terms_) {
    const bool wanted = term.factor && term.weight != 0.0;
    if (wanted && !term.in_pattern) return false;
    has_spare = has_spare || (term.in_pattern && !wanted);
  }
  return !(has_spare && system_->is_worn());
}

void SparseProblem::lay_out() {
  std::vector<int> sizes;
  for (const Variable& variable : variables_) {
    if (variable.block != kConstant) sizes.push_back(variable.type.tangent);
  }
  std::vector<std::pair<int, int>> pairs;
  const auto for_each_pair = [&](const Term& term, auto&& use) {
    for (std::size_t a = 0; a < term.variables.size(); ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        const int i = variables_[term.variables[a]].block;
        const int j = variables_[term.variables[b]].block;
        if (i != kConstant && j != kConstant) use(static_cast<int>(a), i, static_cast<int>(b), j);
      }
    }
  };
  for (Term& term : terms_) {
    term.in_pattern = term.factor && term.weight != 0.0;
    if (!term.in_pattern) continue;
    for_each_pair(term, [&](int, int i, int, int j) { pairs.emplace_back(i, j); });
  }
  system_.emplace(BlockCholesky(sizes, pairs));
  for (Term& term : terms_) {
    term.products.clear();
    if (!term.in_pattern) continue;
    for_each_pair(term, [&](int a, int i, int b, int j) {
      const BlockCholesky::Place place = system_->H.place(i, j);
      const bool as_given = place.row_variable == i;
      term.products.push_back({as_given ? a : b, as_given ? b : a, place.first, place.stride});
    });
  }
}

double SparseProblem::evaluate(const Term& term, const State& x, bool with_jacobians) {
  const Factor& factor = *term.factor;
  double* free = J_.data();
  for (std::size_t k = 0; k < term.variables.size(); ++k) {
    x_[k] = x.data() + term.variables[k] * kMaxAmbient;
    jacobians_[k] = free;
    free += factor.residual_dim() * factor.types()[k].tangent;
  }
  factor.evaluate(x_.data(), r_.data(), with_jacobians ? jacobians_.data() : nullptr);
  Eigen::Map<Eigen::VectorXd> r(r_.data(), factor.residual_dim());
  const double squared = term.weight * r.squaredNorm();
  if (with_jacobians) {
    const double scale = std::sqrt(term.weight * term.robust.derivative(squared));
    if (scale != 1.0) {
      r *= scale;
      Eigen::Map<Eigen::VectorXd>(J_.data(), free - J_.data()) *= scale;
    }
  }
  return term.robust.cost(squared);
}

double SparseProblem::cost(const State& x) {
  double sum = 0.0;
  for (const Term& term : terms_) {
    if (term.factor && term.weight != 0.0) sum += evaluate(term, x, false);
  }
  return sum;
}

void SparseProblem::linearise(const State& x) {
  BlockCholesky& H = system_->H;
  H.set_zero();
  gradient_.setZero(H.rows());
  for (const Term& term : terms_) {
    if (!term.factor || term.weight == 0.0) continue;
    evaluate(term, x, true);
    const Factor& factor = *term.factor;
    const int rows = factor.residual_dim();
    for (std::size_t k = 0; k < term.variables.size(); ++k) {
      const int block = variables_[term.variables[k]].block;
      if (block == kConstant) continue;
      const int size = factor.types()[k].tangent;
      const Eigen::Map<const RowMajorMatrix> J(jacobians_[k], rows, size);
      gradient_.segment(H.first_row(block), size) +=
          J.transpose().lazyProduct(Eigen::Map<const Eigen::VectorXd>(r_.data(), rows));
    }
    for (const Term::Product& product : term.products) {
      add_product(jacobians_[product.row], jacobians_[product.column], rows,
                  factor.types()[product.row].tangent, factor.types()[product.column].tangent,
                  H.values() + product.first, product.stride);
    }
  }
}

}  // namespace covey::graph
