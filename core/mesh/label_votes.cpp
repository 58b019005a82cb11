// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/label_votes.h"

#include <cmath>

namespace covey::mesh {
namespace {

constexpr std::uint8_t kMostVotes = 255;

}  // namespace

void LabelVotes::observe(std::uint8_t label) {
  if (label == kUnknownLabel) return;
  std::size_t place = kKept;
  for (std::size_t i = 0; i < kKept; ++i) {
    if (counts_[i] > 0 && labels_[i] == label) {
      place = i;
      break;
    }
    if (counts_[i] == 0 && place == kKept) place = i;
  }
  const bool others_lose = place == kKept || counts_[place] == kMostVotes;
  if (!others_lose) {
    labels_[place] = label;
    ++counts_[place];
    return;
  }
  for (std::size_t i = 0; i < kKept; ++i) {
    if (i != place && counts_[i] > 0) --counts_[i];
  }
}

std::uint8_t LabelVotes::likeliest() const {
  std::uint8_t best = kUnknownLabel;
  int most = 0;
  for (std::size_t i = 0; i < kKept; ++i) {
    if (counts_[i] > most || (counts_[i] == most && most > 0 && labels_[i] < best)) {
      best = labels_[i];
      most = counts_[i];
    }
  }
  return best;
}

int LabelVotes::count(std::uint8_t label) const {
  for (std::size_t i = 0; i < kKept; ++i) {
    if (counts_[i] > 0 && labels_[i] == label) return counts_[i];
  }
  return 0;
}

double LabelVotes::posterior(std::uint8_t label, const LabelModel& model) const {
  const double delta = std::log(model.accuracy * (model.classes - 1) / (1.0 - model.accuracy));
  const double of_label = delta * count(label);
  double sum = 0.0;  // relative to the label's own, so that nothing overflows
  int kept = 0;
  for (const std::uint8_t votes : counts_) {
    if (votes == 0) continue;
    ++kept;
    sum += std::exp(delta * votes - of_label);
  }
  return 1.0 / (sum + (model.classes - kept) * std::exp(-of_label));
}

}  // namespace covey::mesh
