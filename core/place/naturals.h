// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The range code (core/pgo/range_code.h) is of numbers around zero. Those from zero on are taken to them first, 0, 1, 2, 3 ... to
// 0, -1, 1, -2 ..., so that no bit of theirs is spent on a sign that all have.

#include <cstdint>

#include "core/pgo/range_code.h"

namespace covey::place {

constexpr std::int32_t kLargestNatural = 2 * pgo::kLargestCoded;

inline void put_natural(pgo::RangeWriter& writer, std::int32_t natural, pgo::NumberModel& model) {
  writer.put(natural % 2 == 1 ? -(natural + 1) / 2 : natural / 2, model);
}

inline std::int32_t get_natural(pgo::RangeReader& reader, pgo::NumberModel& model) {
  const std::int32_t number = reader.get(model);
  return number < 0 ? -2 * number - 1 : 2 * number;
}

}  // namespace covey::place
