// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/inventory.h"

#include <algorithm>

#include "core/place/naturals.h"

namespace covey::place {
namespace {

struct InventoryModels {
  pgo::NumberModel stretches;
  pgo::NumberModel last;
  pgo::NumberModel there;
  pgo::NumberModel missing;
  pgo::NumberModel cut;
};

void put(pgo::RangeWriter& writer, const IdRanges& ids, InventoryModels& models) {
  const auto all = static_cast<int>(ids.stretches().size());
  const int said = std::min(all, kMostStretches);
  put_natural(writer, said - 1, models.stretches);
  put_natural(writer, ids.last(), models.last);
  int below = ids.last() + 1;
  auto stretch = ids.stretches().rbegin();
  for (int k = 0; k < said; ++k, ++stretch) {
    if (k > 0) put_natural(writer, below - stretch->second - 2, models.missing);
    put_natural(writer, stretch->second - stretch->first, models.there);
    below = stretch->first;
  }
  put_natural(writer, said < all ? 1 : 0, models.cut);
}

const char* get(pgo::RangeReader& reader, RunInventory& run, InventoryModels& models) {
  const int said = 1 + get_natural(reader, models.stretches);
  if (said > kMostStretches) return "ids";
  int last = get_natural(reader, models.last);
  if (last > kMostId) return "ids";
  for (int k = 0; k < said; ++k) {
    if (k > 0) last = run.said_from - 2 - get_natural(reader, models.missing);
    const int first = last - get_natural(reader, models.there);
    if (first < 0) return "ids";
    run.ids.add(first, last);
    run.said_from = first;
  }
  if (get_natural(reader, models.cut) == 0) run.said_from = 0;
  return nullptr;
}

}  // namespace

std::vector<std::uint8_t> encode_ids(const std::vector<RunInventory>& runs) {
  pgo::RangeWriter writer;
  InventoryModels models;
  for (const RunInventory& run : runs) put(writer, run.ids, models);
  return writer.finish();
}

const char* decode_ids(const std::vector<std::uint8_t>& code, std::vector<RunInventory>& runs) {
  pgo::RangeReader reader(code);
  InventoryModels models;
  for (RunInventory& run : runs) {
    if (const char* reason = get(reader, run, models)) return reason;
  }
  return reader.ended_well() ? nullptr : "code";
}

}  // namespace covey::place
