// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/frame_alignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/base/error.h"
#include "core/graph/gnc.h"
#include "core/pgo/alignment_evidence.h"
#include "core/pgo/chi_square.h"
#include "core/pgo/tls.h"

namespace covey::pgo {
namespace {

// Candidates tried as a first estimate: all of them up to this many, then evenly spread ones. Bounds the time
// of a pair.
constexpr int kMaxSeeds = 300;

constexpr std::size_t kMostPossible = 64;

struct Averaging {
  const std::vector<SE3>& candidates;
  double rotation_precision;     // 1 / sigma_R^2
  double translation_precision;  // 1 / sigma_t^2
  double barc2;

  double squared_residual(const SE3& T, const SE3& candidate) const {
    const double cosine = std::abs(T.rotation.quaternion().dot(candidate.rotation.quaternion()));
    const double angle = 2.0 * std::acos(std::min(1.0, cosine));
    return rotation_precision * angle * angle +
           translation_precision * (T.translation - candidate.translation).squaredNorm();
  }

  std::vector<double> squared_residuals(const SE3& T) const {
    std::vector<double> r2(candidates.size());
    for (std::size_t k = 0; k < r2.size(); ++k) r2[k] = squared_residual(T, candidates[k]);
    return r2;
  }

  double tls_cost(const SE3& T) const {
    double cost = 0.0;
    for (const SE3& candidate : candidates) cost += std::min(squared_residual(T, candidate), barc2);
    return cost;
  }

  // The weighted average: mean translation and Karcher mean rotation, which do not depend on each other.
  SE3 average(const std::vector<double>& weights, SE3 T) const {
    double total = 0.0;
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      total += weights[k];
      translation += weights[k] * candidates[k].translation;
    }
    if (total <= 0.0) return T;
    T.translation = translation / total;
    for (int i = 0; i < 20; ++i) {
      Eigen::Vector3d step = Eigen::Vector3d::Zero();
      for (std::size_t k = 0; k < candidates.size(); ++k) {
        if (weights[k] > 0.0) step += weights[k] * (T.rotation.inverse() * candidates[k].rotation).log();
      }
      step /= total;
      T.rotation = T.rotation * SO3::exp(step);
      if (step.norm() < 1e-9) break;
    }
    return T;
  }

  // Averages the candidates below the threshold until they stay the same; the TLS cost falls in every step.
  SE3 descend(SE3 T) const {
    std::vector<double> weights;
    for (int i = 0; i < 50; ++i) {
      std::vector<double> next = squared_residuals(T);
      for (double& value : next) value = value < barc2 ? 1.0 : 0.0;
      if (next == weights) break;
      weights = std::move(next);
      T = average(weights, T);
    }
    return T;
  }

  SE3 graduate(SE3 T) const {
    T = average(std::vector<double>(candidates.size(), 1.0), T);
    std::vector<double> r2 = squared_residuals(T);
    for (double mu = tls_first_mu(*std::max_element(r2.begin(), r2.end()), barc2); mu < 1e4; mu *= 1.4) {
      for (double& value : r2) value = graph::gnc_weight(value, barc2, mu);
      T = average(r2, T);
      r2 = squared_residuals(T);
    }
    return T;
  }

  // Graduated non-convexity can lose the right set when wrong candidates are many and far on one side; the
  // candidate that the others agree with most is then the better start. Both are cheap, so both are done.
  SE3 minimise() const {
    const int count = static_cast<int>(candidates.size());
    const int seeds = std::min(count, kMaxSeeds);
    SE3 seed = candidates.front();
    double seed_cost = std::numeric_limits<double>::infinity();
    for (int s = 0; s < seeds; ++s) {
      const SE3& candidate = candidates[static_cast<std::size_t>(s) * count / seeds];
      const double cost = tls_cost(candidate);
      if (cost < seed_cost) {
        seed_cost = cost;
        seed = candidate;
      }
    }
    const SE3 agreed = descend(seed);
    const SE3 graduated = descend(graduate(seed));
    return tls_cost(graduated) < tls_cost(agreed) ? graduated : agreed;
  }

  AlignmentResult result(const SE3& T_A_B, const AlignmentOptions& options) const {
    AlignmentResult result;
    result.T_A_B = T_A_B;
    result.total = static_cast<int>(candidates.size());
    double sum = 0.0;
    for (const double r2 : squared_residuals(T_A_B)) {
      result.kept.push_back(r2 < barc2);
      if (!result.kept.back()) continue;
      ++result.inliers;
      sum += r2;
    }
    result.rms = result.inliers > 0 ? std::sqrt(sum / result.inliers) : 0.0;
    result.ok = result.inliers >= options.min_inliers;
    return result;
  }
};

Averaging averaging_of(const std::vector<SE3>& candidates, const AlignmentOptions& options) {
  return {candidates, 1.0 / (options.rotation_sigma * options.rotation_sigma),
          1.0 / (options.translation_sigma * options.translation_sigma),
          chi_square_quantile(options.probability, pose_degrees_of_freedom(options.dimension))};
}

bool beyond_doubt(const AlignmentResult& best) {
  const double log_odds = 5.0;
  const double chance = std::max(kUsualChance, 1.0 / best.total);
  return log_evidence(best.inliers, best.total, chance, true) > log_odds;
}

// Of all candidates, those of the rest that are kept.
std::vector<bool> kept_of_all(const std::vector<bool>& taken, const std::vector<bool>& kept_of_rest) {
  std::vector<bool> kept(taken.size(), false);
  std::size_t rest = 0;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    if (!taken[k]) kept[k] = kept_of_rest[rest++];
  }
  return kept;
}

}  // namespace

AlignmentResult align_pair(const std::vector<SE3>& candidates, const AlignmentOptions& options) {
  if (candidates.empty()) return {};
  const Averaging averaging = averaging_of(candidates, options);
  return averaging.result(averaging.minimise(), options);
}

std::vector<AlignmentResult> possible_alignments(const std::vector<SE3>& candidates,
                                                 const AlignmentOptions& options) {
  if (candidates.empty()) return {};
  std::vector<AlignmentResult> possible = {align_pair(candidates, options)};
  if (beyond_doubt(possible.front())) return possible;
  const double by_chance = kUsualChance * static_cast<double>(candidates.size());
  std::vector<bool> taken = possible.front().kept;
  while (possible.size() < kMostPossible) {
    std::vector<SE3> rest;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (!taken[k]) rest.push_back(candidates[k]);
    }
    AlignmentResult next = align_pair(rest, options);
    if (!next.ok || next.inliers <= by_chance) break;
    next.total = static_cast<int>(candidates.size());
    next.kept = kept_of_all(taken, next.kept);
    for (std::size_t k = 0; k < taken.size(); ++k) taken[k] = taken[k] || next.kept[k];
    possible.push_back(std::move(next));
  }
  return possible;
}

AlignmentResult confirm_same_frame(const std::vector<SE3>& candidates, const AlignmentOptions& options) {
  if (candidates.empty()) return {};
  const Averaging averaging = averaging_of(candidates, options);
  AlignmentResult same = averaging.result(SE3{}, options);
  if (options.keep_same_frame) return same;
  AlignmentResult best = averaging.result(averaging.minimise(), options);
  const bool near = averaging.squared_residual(SE3{}, best.T_A_B) < averaging.barc2;
  return near || same.inliers >= best.inliers ? same : best;
}

}  // namespace covey::pgo
