// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A set of whole numbers that mostly follow each other: kept as the stretches without a gap.

#include <map>

namespace covey::place {

class IdRanges {
 public:
  // False: it was there already.
  bool add(int id) { return add(id, id); }
  // Those that were there stay; false: none is new.
  bool add(int first, int last);
  bool contains(int id) const;
  bool empty() const { return stretches_.empty(); }
  int last() const { return stretches_.rbegin()->second; }
  const std::map<int, int>& stretches() const {
    return stretches_;
  }  // first -> last, ascending, not touching
  bool operator==(const IdRanges&) const = default;

 private:
  std::map<int, int> stretches_;
};

}  // namespace covey::place
