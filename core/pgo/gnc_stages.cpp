// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/gnc_stages.h"

#include <limits>

#include "core/pgo/tls.h"

namespace covey::pgo {

bool GncStages::converged(const TeamUpdate& team) const {
  return team.decrease <= (final_ ? options_.final_tolerance : options_.tolerance) * team.cost;
}

bool GncStages::ended(const TeamUpdate& team) const {
  if (!begun_) return true;
  if (final_ && settled(team)) return true;
  const int limit = !options_.robust ? options_.max_updates
                    : final_         ? options_.final_updates
                                     : options_.updates;
  return stage_updates_ >= limit || converged(team);
}

bool GncStages::begin(const TeamUpdate& team, double first_mu) {
  if (begun_ && !options_.robust) return false;
  if (final_ && (settled(team) || final_stages_ >= options_.final_stages)) return false;
  if (!options_.robust) {
    mu_ = std::numeric_limits<double>::infinity();
  } else if (!begun_) {
    mu_ = first_mu;
    final_ = mu_ > options_.mu_max;
  } else if (!final_) {
    mu_ *= options_.mu_step;
    final_ = team.undecided == 0 || mu_ > options_.mu_max;
  }
  begun_ = true;
  ++stages_;
  if (final_) ++final_stages_;
  stage_updates_ = 0;
  return true;
}

double GncStages::weight(double r2) const {
  return final_ ? (r2 < options_.barc2 ? 1.0 : 0.0) : tls_weight(r2, options_.barc2, mu_);
}

bool GncStages::undecided(double weight, double weight_before) const {
  return final_ ? weight != weight_before : weight > 0.0 && weight < 1.0;
}

}  // namespace covey::pgo
