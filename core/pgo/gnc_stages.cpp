// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/gnc_stages.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/pgo/tls.h"

namespace covey::pgo {
namespace {

// Loops beyond 150 barc^2 are told from the rest by two leaps of mu; those nearer want steps of about two. DECISIONS.md has
// both measured.
constexpr double kMuOfSmallSteps = 0.007;
constexpr double kLastMu = 1.0;
constexpr double kSmallestStep = 1.4;

}  // namespace

bool GncStages::converged(const TeamUpdate& team) const {
  // Before another choice of sides there is no need to be exact.
  const bool last = final_ && (team.undecided == 0 || final_stages_ >= options_.final_stages);
  return team.decrease <= (last ? options_.final_tolerance : options_.tolerance) * team.cost;
}

bool GncStages::used_up() const { return options_.total_updates > 0 && updates_ >= options_.total_updates; }

bool GncStages::ended(const TeamUpdate& team) const {
  if (!begun_ || used_up()) return true;
  const int limit = !options_.robust ? options_.max_updates
                    : final_         ? options_.final_updates
                                     : options_.updates;
  return stage_updates_ >= limit || converged(team);
}

bool GncStages::begin(const TeamUpdate& team, double first_mu) {
  if (begun_ && (!options_.robust || used_up())) return false;
  if (final_ && (settled(team) || final_stages_ >= options_.final_stages)) return false;
  if (!options_.robust) {
    mu_ = std::numeric_limits<double>::infinity();
  } else if (!begun_) {
    mu_ = std::min(first_mu, 2.0 * options_.mu_max);
    leap_ = std::max(std::sqrt(kMuOfSmallSteps / mu_), kSmallestStep);
    final_ = mu_ > options_.mu_max;
  } else if (!final_) {
    mu_ = next_mu();
    final_ = team.undecided == 0 || mu_ > options_.mu_max;
  }
  begun_ = true;
  ++stages_;
  if (final_) ++final_stages_;
  stage_updates_ = 0;
  return true;
}

double GncStages::next_mu() const {
  if (options_.mu_step > 0.0) return mu_ * options_.mu_step;
  if (mu_ < 0.99 * kMuOfSmallSteps) return std::min(mu_ * leap_, kMuOfSmallSteps);
  // The first stage, two leaps and the final stage are not of these.
  const double step = std::pow(kLastMu / kMuOfSmallSteps, 1.0 / std::max(1, options_.rounds - 4));
  return mu_ > 0.99 * kLastMu ? 2.0 * options_.mu_max : std::max(step, kSmallestStep) * mu_;
}

double GncStages::weight(double r2) const {
  return final_ ? (r2 < options_.barc2 ? 1.0 : 0.0) : tls_weight(r2, options_.barc2, mu_);
}

double GncStages::rejection() const { return final_ ? options_.barc2 : (mu_ + 1.0) / mu_ * options_.barc2; }

bool GncStages::undecided(double weight, double weight_before) const {
  return final_ ? weight != weight_before : weight > 0.0 && weight < 1.0;
}

}  // namespace covey::pgo
