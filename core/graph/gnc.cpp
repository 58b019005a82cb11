// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/gnc.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/graph/sparse_problem.h"

namespace covey::graph {
namespace {

constexpr double kSmallestMu =
    1e-15;  // against overflow only: a floor that binds would reject everything at once
constexpr int kMaxHardRounds = 20;
constexpr double kLastMu = 3.0;
constexpr int kEvenSteps = 6;

class Gnc {
 public:
  Gnc(const Graph& graph, Values& values, const GncOptions& options)
      : graph_(graph), values_(values), options_(options), problem_(graph, values) {
    result_.weights.assign(options.candidates.size(), 1.0);
    squared_.resize(options.candidates.size());
  }

  GncResult run() {
    measure();
    result_.initial_cost = truncated_cost();
    if (options_.solve_before_weighting) solve(options_.annealing);
    anneal();
    choose();
    result_.final_cost = truncated_cost();
    result_.inliers = static_cast<int>(std::count(result_.weights.begin(), result_.weights.end(), 1.0));
    return std::move(result_);
  }

 private:
  void anneal() {
    double mu = options_.mu_initial > 0.0 ? options_.mu_initial : mu_from_largest_residual();
    if (mu <= 0.0) return;  // no candidate is beyond barc enough to matter: the problem is convex already
    double last_cost = 0.0;
    for (int round = 0; round < options_.max_rounds && std::isfinite(mu); ++round) {
      result_.rounds.push_back(minimise_surrogate(mu));
      const double cost = result_.rounds.back().weighted_cost;
      const bool stands_still = round > 0 && std::abs(cost - last_cost) <=
                                                 options_.relative_cost_tolerance * std::max(cost, 1e-300);
      if (result_.rounds.back().undecided == 0 || stands_still) return;
      last_cost = cost;
      mu = next_mu(mu, options_.mu_step, kEvenSteps);
    }
  }

  // Each weighing and each solve lowers it (Yang et al., eq. 12).
  GncRound minimise_surrogate(double mu) {
    const int most = mu < 0.99 * kMuOfDecisions ? 1 : options_.max_weighings;
    for (int weighings = 1;; ++weighings) {
      set_weights([&](double squared) { return gnc_weight(squared, options_.barc_squared, mu); });
      const auto undecided = std::count_if(result_.weights.begin(), result_.weights.end(),
                                           [](double w) { return w > 0.0 && w < 1.0; });
      const SolveResult solved = solve(options_.annealing);
      const double enough =
          options_.weighing_tolerance * options_.barc_squared * static_cast<double>(undecided);
      if (solved.initial_cost - solved.final_cost <= enough || weighings >= most)
        return {mu, solved.final_cost, static_cast<int>(undecided)};
    }
  }

  // Alternates between the best binary weights for the values and the best values for these weights.
  void choose() {
    for (int round = 0; round < kMaxHardRounds; ++round) {
      const std::vector<double> before = result_.weights;
      set_weights([&](double squared) { return squared <= options_.barc_squared ? 1.0 : 0.0; });
      if (round > 0 && result_.weights == before) return;
      solve(options_.last);
    }
  }

  double mu_from_largest_residual() const {
    const double largest = squared_.empty() ? 0.0 : *std::max_element(squared_.begin(), squared_.end());
    const double excess = 2.0 * largest - options_.barc_squared;
    return excess > 0.0 ? std::max(options_.barc_squared / excess, kSmallestMu) : 0.0;
  }

  template <typename WeightOf>
  void set_weights(WeightOf&& weight_of) {
    for (std::size_t k = 0; k < squared_.size(); ++k) {
      result_.weights[k] = weight_of(squared_[k]);
      problem_.set_weight(options_.candidates[k], result_.weights[k]);
    }
  }

  SolveResult solve(const SolveOptions& options) {
    SolveResult solved = problem_.solve(options);
    result_.iterations += solved.iterations;
    result_.converged = solved.converged;
    result_.message = solved.message;
    measure();
    return solved;
  }

  void measure() {
    for (std::size_t k = 0; k < squared_.size(); ++k)
      squared_[k] = problem_.squared_residual(options_.candidates[k]);
  }

  double truncated_cost() const {
    double sum = cost(graph_, values_);
    for (std::size_t k = 0; k < squared_.size(); ++k) {
      sum += std::min(squared_[k], options_.barc_squared) -
             graph_.robust(options_.candidates[k]).cost(squared_[k]);
    }
    return sum;
  }

  const Graph& graph_;
  Values& values_;
  const GncOptions& options_;
  SparseProblem problem_;
  std::vector<double> squared_;  // r^2 of each candidate at the present values
  GncResult result_;
};

}  // namespace

double gnc_weight(double squared, double barc_squared, double mu) {
  if (squared >= (mu + 1.0) / mu * barc_squared) return 0.0;
  if (squared <= mu / (mu + 1.0) * barc_squared) return 1.0;
  return std::sqrt(barc_squared * mu * (mu + 1.0) / squared) - mu;
}

double next_mu(double mu, double early_step, int even_steps) {
  if (mu < 0.99 * kMuOfDecisions) return std::min(mu * early_step, kMuOfDecisions);
  if (mu > 0.99 * kLastMu) return std::numeric_limits<double>::infinity();
  return mu * std::pow(kLastMu / kMuOfDecisions, 1.0 / even_steps);
}

GncResult solve_gnc(const Graph& graph, Values& values, const GncOptions& options) {
  return Gnc(graph, values, options).run();
}

}  // namespace covey::graph
