// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The name of a variable: a letter for what it is and a number, e.g. {'x', 12} for pose 12. Whoever builds a
// graph chooses the letters and how the number is composed. Keys are ordered, which makes every loop over
// variables deterministic.

#include <compare>
#include <cstdint>

namespace covey::graph {

struct Key {
  char kind = 0;
  std::uint64_t id = 0;

  auto operator<=>(const Key&) const = default;
};

}  // namespace covey::graph
