// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/descriptor_matcher.h"

#include <algorithm>

namespace covey::place {
namespace {

struct Nearest {
  int index = -1;
  int distance = kDescriptorBits + 1;
  int second = kDescriptorBits + 1;  // distance of the second nearest
};

// Of each of a the nearest of b, and of each of b the nearest of a; of equally near ones the first.
COVEY_COUNTS_BITS void compare(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                               std::vector<Nearest>& of_a, std::vector<Nearest>& of_b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    Nearest nearest;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int distance = hamming(a[i], b[j]);
      if (distance < nearest.distance) {
        nearest = {static_cast<int>(j), distance, nearest.distance};
      } else {
        nearest.second = std::min(nearest.second, distance);
      }
      if (distance < of_b[j].distance) of_b[j] = {static_cast<int>(i), distance};
    }
    of_a[i] = nearest;
  }
}

}  // namespace

std::vector<std::pair<int, int>> match_descriptors(const std::vector<Descriptor>& a,
                                                   const std::vector<Descriptor>& b,
                                                   const MatchOptions& options) {
  std::vector<std::pair<int, int>> matches;
  if (a.size() < 2 || b.size() < 2) return matches;
  if (a.size() > b.size()) {
    for (const auto& [in_b, in_a] : match_descriptors(b, a, options)) matches.emplace_back(in_a, in_b);
    std::sort(matches.begin(), matches.end());
    return matches;
  }
  std::vector<Nearest> there(a.size());
  std::vector<Nearest> back(b.size());
  compare(a, b, there, back);
  for (int i = 0; i < static_cast<int>(a.size()); ++i) {
    const Nearest& nearest = there[static_cast<std::size_t>(i)];
    if (nearest.distance > options.most_distance) continue;
    if (nearest.distance > options.ratio * nearest.second) continue;
    if (back[static_cast<std::size_t>(nearest.index)].index == i) matches.emplace_back(i, nearest.index);
  }
  return matches;
}

}  // namespace covey::place
