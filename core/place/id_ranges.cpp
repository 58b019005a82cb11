// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/id_ranges.h"

#include <algorithm>
#include <iterator>

namespace covey::place {

bool IdRanges::add(int first, int last) {
  auto next = stretches_.upper_bound(first);
  if (next != stretches_.begin()) {
    const auto before = std::prev(next);
    if (before->second >= last) return false;
    if (before->second >= first - 1) {
      first = before->first;
      next = before;
    }
  }
  while (next != stretches_.end() && next->first <= last + 1) {
    last = std::max(last, next->second);
    next = stretches_.erase(next);
  }
  stretches_.emplace(first, last);
  return true;
}

bool IdRanges::contains(int id) const {
  const auto next = stretches_.upper_bound(id);
  return next != stretches_.begin() && std::prev(next)->second >= id;
}

}  // namespace covey::place
