// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/gnc_stages.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/graph/gnc.h"

namespace covey::pgo {
namespace {

constexpr double kRise = 7.0;            // of mu, by an update
constexpr int kUpdatesPerBinaryOne = 5;  // where updates are few

}  // namespace

bool GncStages::converged(const TeamUpdate& team) const {
  const bool last = final_ && (team.undecided == 0 || final_stages_ >= options_.final_stages);
  if (last || !options_.robust) return team.decrease <= options_.final_tolerance * team.cost;
  // What rejected loops cost says nothing of how exact a stage has to be; those that its end may still decide do.
  const double enough = options_.undecided_tolerance * options_.barc2 * static_cast<double>(team.undecided);
  return team.decrease <= std::max(enough, options_.tolerance * (team.cost - team.penalty)) ||
         team.undecided == 0;
}

bool GncStages::used_up() const { return options_.total_updates > 0 && updates_ >= options_.total_updates; }

// Loops between the sides bend the poses of a round that ends early, so its last updates have binary weights.
bool GncStages::has_to_decide() const {
  const int left = options_.total_updates / kUpdatesPerBinaryOne;
  return options_.robust && options_.total_updates > 0 && updates_ >= options_.total_updates - left;
}

bool GncStages::mu_rises() const {
  return options_.robust && options_.mu_step == 0.0 && !final_ && mu_ < 0.99 * graph::kMuOfDecisions;
}

void GncStages::count_update() {
  ++stage_updates_;
  ++updates_;
  rose_ = mu_rises();
  if (rose_) mu_ = std::min(kRise * mu_, graph::kMuOfDecisions);
}

bool GncStages::ended(const TeamUpdate& team) const {
  if (!begun_ || used_up() || (!final_ && has_to_decide())) return true;
  if (mu_rises()) return team.undecided == 0;
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
    final_ = mu_ > options_.mu_max;
  } else if (!final_) {
    mu_ = next_mu();
    final_ = team.undecided == 0 || mu_ > options_.mu_max || has_to_decide();
  }
  begun_ = true;
  ++stages_;
  if (final_) ++final_stages_;
  stage_updates_ = 0;
  return true;
}

double GncStages::next_mu() const {
  if (options_.mu_step > 0.0) return mu_ * options_.mu_step;
  // The first stage and the first binary one are not of the even steps.
  return std::min(graph::next_mu(mu_, kRise, std::max(1, options_.rounds - 2)), 2.0 * options_.mu_max);
}

bool GncStages::weighs() const {
  return stage_updates_ == 0 || (!final_ && (options_.mu_step == 0.0 || mu_ >= 0.99 * graph::kMuOfDecisions));
}

double GncStages::weight(double r2) const {
  return final_ ? (r2 < options_.barc2 ? 1.0 : 0.0) : graph::gnc_weight(r2, options_.barc2, mu_);
}

// Phi of Black and Rangarajan's duality (Yang et al., RA-L 2020, eq. 13).
double GncStages::penalty(double weight) const {
  return final_ ? 0.0 : mu_ * (1.0 - weight) / (mu_ + weight) * options_.barc2;
}

double GncStages::rejection() const { return final_ ? options_.barc2 : (mu_ + 1.0) / mu_ * options_.barc2; }

bool GncStages::undecided(double weight, double weight_before) const {
  return final_ ? weight != weight_before : weight > 0.0 && weight < 1.0;
}

}  // namespace covey::pgo
