// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Graduated non-convexity for truncated least squares: minimises
//
//   sum over known inliers of r^2 + sum over candidates of min(r^2, barc^2)
//
// by weighted least squares with weights that are annealed from nearly convex (mu small) to binary (mu
// large):
//
//   w = 0 if r^2 >= (mu + 1) / mu barc^2,  1 if r^2 <= mu / (mu + 1) barc^2,  else barc sqrt(mu (mu + 1)) /
//   |r| - mu
//
// mu starts from the largest residual of the candidates, mu_0 = barc^2 / (2 r_max^2 - barc^2), and grows until the
// weights are binary or the cost stands still. From kMuOfDecisions on weights and values are found in turns at each mu until
// they agree, which minimises that mu's surrogate of the truncated cost: only then may mu grow by large steps. Before, one
// weighing has to do: all candidates pull there, and the minimum is bent by the wrong ones, however good the start. Then hard rounds (w = 1 where r^2
// <= barc^2, solve) run until the choice repeats; each can only lower the truncated cost. r^2 is the factor's
// |whitened residual|^2, without 1/2 and before any robust kernel. Factors that are not candidates keep
// weight 1: they must hold the graph together. Source: Yang, Antonante, Tzoumas, Carlone, "Graduated
// Non-Convexity for Robust Spatial Perception", RA-L 2020, eqs. 12-15.

#include <string>
#include <vector>

#include "core/graph/solve.h"

namespace covey::graph {

struct GncOptions {
  std::vector<FactorId> candidates;  // the factors that may be outliers
  double barc_squared =
      16.81;                // the largest r^2 of an inlier; chi^2 quantile, here 99 % of 6 degrees of freedom
  double mu_step = 1.4;     // before kMuOfDecisions; then six even steps
  double mu_initial = 0.0;  // 0: from the largest residual
  bool solve_before_weighting =
      false;  // true: solve with all weights 1 first. Better left out when the start is good
  int max_rounds = 100;
  int max_weighings = 40;  // per round, from kMuOfDecisions on
  // A mu's surrogate is minimised when a solve lowers it by less than this part of barc_squared for each candidate that is
  // undecided.
  double weighing_tolerance = 1e-5;
  double relative_cost_tolerance = 1e-5;
  SolveOptions annealing{.max_iterations = 3, .relative_cost_tolerance = 1e-2};  // the solves while mu grows
  SolveOptions last;                                                             // the hard rounds
};

struct GncRound {
  double mu = 0.0;
  double weighted_cost = 0.0;
  int undecided = 0;  // candidates with 0 < w < 1
};

struct GncResult {
  std::vector<double> weights;  // 0 or 1 per candidate, in the order of the options
  int inliers = 0;              // candidates with weight 1; 0 of many means that barc does not fit the noise
  double initial_cost = 0.0;    // truncated cost, as defined above
  double final_cost = 0.0;
  int iterations = 0;      // steps of all solves
  bool converged = false;  // of the last hard round
  std::string message;
  std::vector<GncRound> rounds;
};

GncResult solve_gnc(const Graph& graph, Values& values, const GncOptions& options);

// The weight of the formula above.
double gnc_weight(double squared, double barc_squared, double mu);

// Where what is beyond 144 barc_squared has weight 0.
constexpr double kMuOfDecisions = 0.007;

// The mu after this one on the way to binary weights (infinite): by early_step to kMuOfDecisions, then to 3 in so many even steps.
double next_mu(double mu, double early_step, int even_steps);

}  // namespace covey::graph
