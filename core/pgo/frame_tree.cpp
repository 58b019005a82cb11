// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/frame_tree.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/pgo/alignment_evidence.h"

namespace covey::pgo {
namespace {

// Of the drift around a cycle: a fixed part, and one of the way.
constexpr double kRotationSigma = 0.1;     // rad
constexpr double kTranslationSigma = 0.5;  // m
constexpr double kDrift = 0.005;           // m per m
constexpr double kFarthest2 = 11.3;        // in sigmas, squared

// How many pairs of loops it is worth what is thought of their chance to agree before any are seen.
constexpr double kPriorPairs = 10.0;

// By which another place must be likelier than that with the most loops.
constexpr double kLogOdds = 2.0;

constexpr std::size_t kMostOfPair = 64;

// Of two positions around a cycle through both frames.
double translation_sigma(const FrameExtent& a, const FrameExtent& b) {
  return kTranslationSigma + 2.0 * kDrift * (a.way + b.way);
}

bool alike(double angle, double distance, double translation_sigma) {
  const double in_rotation = angle / kRotationSigma;
  const double in_translation = distance / translation_sigma;
  return in_rotation * in_rotation + in_translation * in_translation < kFarthest2;
}

double angle_between(const SE3& T, const SE3& U) { return (T.rotation.inverse() * U.rotation).log().norm(); }

struct Hypothesis {
  SE3 T_A_B;
  double inliers;
};

// The possible alignments of one pair, a < b.
class PairHypotheses {
 public:
  PairHypotheses(const FrameExtent& a, const FrameExtent& b)
      : centre_(b.centre), translation_sigma_(translation_sigma(a, b)) {}

  void add(const SE3& T_A_B, const AlignmentResult& alignment) {
    if (hypotheses_.size() >= kMostOfPair) return;
    hypotheses_.push_back({T_A_B, static_cast<double>(alignment.inliers)});
    loops_ = std::max(loops_, alignment.total);
  }

  const std::vector<Hypothesis>& all() const { return hypotheses_; }

  void compare() {
    const std::size_t n = hypotheses_.size();
    agree_.assign(n * n, false);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j)
        agree_[i * n + j] = agree(hypotheses_[i].T_A_B, hypotheses_[j].T_A_B);
    }
  }

  // Of the hypothesis itself: its loops agree closely, by having been looked for.
  double own_evidence(std::size_t h) const {
    const std::size_t n = hypotheses_.size();
    double rest = loops_;
    double agreeing_pairs = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (agree_[h * n + i]) {
        rest -= inliers(i);
      } else {
        agreeing_pairs += inliers(i) * (inliers(i) - 1.0);
      }
    }
    return log_evidence(inliers(h), loops_, chance(agreeing_pairs, rest), true);
  }

  // For a place that other loops speak for.
  double evidence(const SE3& T_A_B) const {
    const std::size_t n = hypotheses_.size();
    std::vector<bool> confirms(n);
    for (std::size_t i = 0; i < n; ++i) confirms[i] = agree(hypotheses_[i].T_A_B, T_A_B);
    double confirming = 0.0;
    double agreeing_pairs = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (confirms[i]) {
        confirming += inliers(i);
        continue;
      }
      agreeing_pairs -= inliers(i);
      for (std::size_t j = 0; j < n; ++j) {
        if (!confirms[j] && agree_[i * n + j]) agreeing_pairs += inliers(i) * inliers(j);
      }
    }
    return log_evidence(confirming, loops_, chance(agreeing_pairs, loops_ - confirming), false);
  }

 private:
  double inliers(std::size_t i) const { return hypotheses_[i].inliers; }

  bool agree(const SE3& T, const SE3& U) const {
    return alike(angle_between(T, U), (T * centre_ - U * centre_).norm(), translation_sigma_);
  }

  static double chance(double agreeing_pairs, double loops) {
    const double pairs = std::max(0.0, loops * (loops - 1.0));
    return std::min(1.0, (kUsualChance * kPriorPairs + agreeing_pairs) / (kPriorPairs + pairs));
  }

  Eigen::Vector3d centre_;
  double translation_sigma_;
  std::vector<Hypothesis> hypotheses_;
  std::vector<bool> agree_;
  int loops_ = 0;
};

class Tree {
 public:
  Tree(const std::vector<PairAlignment>& alignments, const std::vector<FrameExtent>& extents, int anchor) {
    frames_.T_W_O.resize(extents.size());
    frames_.T_W_O[anchor] = SE3{};
    for (const PairAlignment& alignment : alignments) {
      if (!alignment.alignment.ok) continue;
      const Key key = std::minmax(alignment.a, alignment.b);
      PairHypotheses& pair = pairs_.try_emplace(key, extents[key.first], extents[key.second]).first->second;
      const SE3& T_A_B = alignment.alignment.T_A_B;
      pair.add(alignment.a < alignment.b ? T_A_B : T_A_B.inverse(), alignment.alignment);
    }
    for (auto& [key, pair] : pairs_) {
      pair.compare();
      pairs_of_[key.first].push_back({key.second, &pair});
      pairs_of_[key.second].push_back({key.first, &pair});
    }
  }

  Frames grow() {
    while (place_next()) {
    }
    return std::move(frames_);
  }

 private:
  using Key = std::pair<int, int>;
  struct Place {
    int parent = -1;
    int child = -1;
    SE3 T_W_O;
    double inliers = 0.0;
    double own_evidence = 0.0;  // of the loops that it was found by
    double evidence = 0.0;      // of all pairs
  };

  bool placed(int frame) const { return frames_.T_W_O[frame].has_value(); }

  bool place_next() {
    std::optional<Place> most_inliers;
    std::optional<Place> most_evidence;
    for (const auto& [key, pair] : pairs_) {
      if (placed(key.first) == placed(key.second)) continue;
      for (std::size_t h = 0; h < pair.all().size(); ++h) {
        const Place place = place_by(key, pair, h);
        if (!most_inliers || place.inliers > most_inliers->inliers) most_inliers = place;
        if (!most_evidence || place.evidence > most_evidence->evidence) most_evidence = place;
      }
    }
    if (!most_inliers) return false;
    const bool could_be_chance = most_inliers->own_evidence <= 0.0;
    const bool gives_way = could_be_chance && most_evidence->evidence > most_inliers->evidence + kLogOdds;
    const Place& best = gives_way ? *most_evidence : *most_inliers;
    frames_.T_W_O[best.child] = best.T_W_O;
    frames_.edges.emplace_back(best.parent, best.child);
    return true;
  }

  Place place_by(const Key& key, const PairHypotheses& pair, std::size_t h) const {
    const auto& [T_A_B, inliers] = pair.all()[h];
    Place place;
    if (placed(key.first)) {
      place.parent = key.first;
      place.child = key.second;
      place.T_W_O = *frames_.T_W_O[place.parent] * T_A_B;
    } else {
      place.parent = key.second;
      place.child = key.first;
      place.T_W_O = *frames_.T_W_O[place.parent] * T_A_B.inverse();
    }
    place.inliers = inliers;
    place.own_evidence = pair.own_evidence(h);
    place.evidence = place.own_evidence;
    for (const auto& [other, confirming] : pairs_of_.at(place.child)) {
      if (confirming == &pair || !placed(other)) continue;
      const SE3 T_other_child = frames_.T_W_O[other]->inverse() * place.T_W_O;
      place.evidence += confirming->evidence(other < place.child ? T_other_child : T_other_child.inverse());
    }
    return place;
  }

  Frames frames_;
  std::map<Key, PairHypotheses> pairs_;
  std::map<int, std::vector<std::pair<int, const PairHypotheses*>>> pairs_of_;  // by frame: the other one
};

}  // namespace

FrameExtent extent_of(const std::vector<SE3>& poses) {
  FrameExtent extent;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    extent.centre += poses[k].translation / static_cast<double>(poses.size());
    if (k > 0) extent.way += (poses[k].translation - poses[k - 1].translation).norm();
  }
  return extent;
}

// Twice as far as elsewhere: what is left out here is not asked any more.
bool explained_by_drift(const SE3& T, const SE3& U, const FrameExtent& a, const FrameExtent& b) {
  return alike(0.5 * angle_between(T, U), 0.5 * (T.translation - U.translation).norm(),
               translation_sigma(a, b));
}

Frames spanning_tree(const std::vector<PairAlignment>& alignments, const std::vector<FrameExtent>& extents,
                     int anchor) {
  COVEY_CHECK(anchor >= 0 && anchor < static_cast<int>(extents.size()));
  return Tree(alignments, extents, anchor).grow();
}

}  // namespace covey::pgo
