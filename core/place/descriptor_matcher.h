// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which point of one image is which of another, by their descriptors alone: nearest neighbours both ways that are clearly nearer
// than the second nearest (Lowe, IJCV 2004). The second nearest is looked for where there are more points: among few there is none that
// is like the nearest, whatever that is.

#include <utility>
#include <vector>

#include "core/place/descriptor.h"

namespace covey::place {

struct MatchOptions {
  double ratio = 0.8;      // of the distances to the nearest and the second nearest, at most
  int most_distance = 64;  // bits
};

// Pairs of indices (a, b), ascending in a; each index at most once.
std::vector<std::pair<int, int>> match_descriptors(const std::vector<Descriptor>& a,
                                                   const std::vector<Descriptor>& b,
                                                   const MatchOptions& options = {});

}  // namespace covey::place
