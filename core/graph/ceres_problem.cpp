// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/ceres_problem.h"

#include <algorithm>
#include <cmath>

#include "core/graph/linearisation_point.h"

namespace covey::graph {
namespace {

class TangentManifold final : public ceres::Manifold {
 public:
  explicit TangentManifold(VariableType type) : type_(type) {}

  int AmbientSize() const override { return type_.ambient; }
  int TangentSize() const override { return type_.tangent; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    plus(type_, x, delta, x_plus_delta);
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    minus(type_, y, x, y_minus_x);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    return set_identity(type_.ambient, type_.tangent, jacobian);
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    return set_identity(type_.tangent, type_.ambient, jacobian);
  }

 private:
  static bool set_identity(int rows, int columns, double* row_major) {
    std::fill_n(row_major, rows * columns, 0.0);
    for (int k = 0; k < std::min(rows, columns); ++k) row_major[k * columns + k] = 1.0;
    return true;
  }

  VariableType type_;
};

std::string first_sentence(const ceres::Solver::Summary& summary) {
  return summary.message.substr(0, summary.message.find('\n'));
}

}  // namespace

class CeresProblem::Cost final : public ceres::CostFunction {
 public:
  Cost(const Graph& graph, const Factor& factor, Values& values, std::vector<double>& scratch)
      : factor_(factor), point_(graph, factor), scratch_(scratch) {
    set_num_residuals(factor.residual_dim());
    std::size_t doubles = 0;
    for (std::size_t k = 0; k < factor.keys().size(); ++k) {
      const VariableType type = factor.types()[k];
      COVEY_CHECK(values.type(factor.keys()[k]) == type);
      mutable_parameter_block_sizes()->push_back(type.ambient);
      parameters_.push_back(values.data(factor.keys()[k]));
      doubles += static_cast<std::size_t>(factor.residual_dim() * type.tangent);
    }
    tangent_jacobians_.resize(factor.keys().size());
    if (scratch_.size() < doubles) scratch_.resize(doubles);
  }

  const std::vector<double*>& parameters() const { return parameters_; }

  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    if (!jacobians) {
      factor_.evaluate(x, residuals, nullptr);
    } else {
      evaluate_with_jacobians(x, residuals, jacobians);
    }
    return Eigen::Map<const Eigen::VectorXd>(residuals, num_residuals()).allFinite();
  }

 private:
  void evaluate_with_jacobians(const double* const* x, double* residuals, double** jacobians) const {
    double* free = scratch_.data();
    for (std::size_t k = 0; k < tangent_jacobians_.size(); ++k) {
      tangent_jacobians_[k] = jacobians[k] ? free : nullptr;
      free += num_residuals() * factor_.types()[k].tangent;
    }
    point_.evaluate(x, residuals, tangent_jacobians_.data());
    for (std::size_t k = 0; k < tangent_jacobians_.size(); ++k) {
      if (jacobians[k]) widen(tangent_jacobians_[k], factor_.types()[k], jacobians[k]);
    }
  }

  void widen(const double* tangent, VariableType type, double* ambient) const {
    for (int row = 0; row < num_residuals(); ++row) {
      std::copy_n(tangent, type.tangent, ambient);
      std::fill(ambient + type.tangent, ambient + type.ambient, 0.0);
      tangent += type.tangent;
      ambient += type.ambient;
    }
  }

  const Factor& factor_;
  LinearisationPoint point_;
  std::vector<double>& scratch_;  // shared by all factors: one thread, one factor at a time
  mutable std::vector<double*> tangent_jacobians_;
  std::vector<double*> parameters_;
};

class CeresProblem::Loss final : public ceres::LossFunction {
 public:
  explicit Loss(Robust robust) : robust_(robust) {}
  void Evaluate(double squared, double rho[3]) const override {
    rho[0] = robust_.cost(squared);
    rho[1] = robust_.derivative(squared);
    rho[2] = robust_.second_derivative(squared);
  }

 private:
  Robust robust_;
};

CeresProblem::CeresProblem(const Graph& graph, Values& values) : graph_(graph), values_(values) {
  manifolds_.push_back(nullptr);  // vectors need none
  for (const VariableType type : {Manifold<SO3>::kType, Manifold<SE2>::kType, Manifold<SE3>::kType}) {
    COVEY_CHECK(manifolds_.size() == static_cast<std::size_t>(type.space));
    manifolds_.push_back(std::make_unique<TangentManifold>(type));
  }
  for (const FactorId id : graph.ids()) {
    costs_.resize(id + 1);
    losses_.resize(id + 1);
    costs_[id] = std::make_unique<Cost>(graph, graph.factor(id), values, scratch_);
    if (graph.robust(id).kind != Robust::Kind::kNone) losses_[id] = std::make_unique<Loss>(graph.robust(id));
  }
}

CeresProblem::~CeresProblem() = default;

void CeresProblem::add_variable(ceres::Problem& problem, Key key, VariableType type) const {
  double* x = values_.data(key);
  problem.AddParameterBlock(x, type.ambient, manifolds_[static_cast<std::size_t>(type.space)].get());
  if (graph_.is_constant(key)) problem.SetParameterBlockConstant(x);
}

std::unique_ptr<ceres::Problem> CeresProblem::make_problem() const {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  auto problem = std::make_unique<ceres::Problem>(options);
  for (const Key key : graph_.keys()) add_variable(*problem, key, values_.type(key));
  for (std::size_t id = 0; id < costs_.size(); ++id) {
    if (!costs_[id]) continue;
    problem->AddResidualBlock(costs_[id].get(), losses_[id].get(), costs_[id]->parameters());
  }
  return problem;
}

std::shared_ptr<ceres::ParameterBlockOrdering> CeresProblem::make_ordering(char first) const {
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const Key key : graph_.keys())
    ordering->AddElementToGroup(values_.data(key), key.kind == first ? 0 : 1);
  return ordering;
}

SolveResult CeresProblem::solve(const SolveOptions& options) {
  SolveResult result;
  result.initial_cost = result.final_cost = cost(graph_, values_);
  if (!std::isfinite(result.initial_cost)) {
    result.message = "The cost at the start is not finite.";
    return result;
  }
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_SCHUR;
  ceres_options.linear_solver_ordering = make_ordering(options.eliminate_first);
  ceres_options.num_threads = 1;
  ceres_options.max_num_iterations = options.max_iterations;
  ceres_options.function_tolerance = options.relative_cost_tolerance;
  ceres_options.gradient_tolerance = options.gradient_tolerance;
  ceres_options.initial_trust_region_radius = options.initial_trust_radius;
  ceres_options.logging_type = ceres::SILENT;

  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, make_problem().get(), &summary);
  result.initial_cost = 2.0 * summary.initial_cost;
  result.final_cost = 2.0 * summary.final_cost;
  result.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.message = first_sentence(summary);
  return result;
}

}  // namespace covey::graph
