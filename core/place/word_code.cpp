// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/word_code.h"

#include <utility>

#include "core/place/naturals.h"

namespace covey::place {
namespace {

struct WordModels {
  pgo::NumberModel gap;
  pgo::NumberModel count;
};

}  // namespace

std::vector<std::uint8_t> encode_words(const WordCounts& counts) {
  pgo::RangeWriter writer;
  WordModels models;
  std::int32_t next = 0;
  for (std::size_t k = 0; k < counts.words.size(); ++k) {
    put_natural(writer, counts.words[k] - next, models.gap);
    put_natural(writer, counts.counts[k] - 1, models.count);
    next = counts.words[k] + 1;
  }
  return writer.finish();
}

const char* decode_words(const std::vector<std::uint8_t>& code, int n, int words, int most,
                         WordCounts& counts) {
  if (n <= 0 || n > most || n > words) return "size";
  pgo::RangeReader reader(code);
  WordModels models;
  WordCounts read;
  std::int32_t next = 0;
  std::int32_t sum = 0;
  for (int k = 0; k < n; ++k) {
    const std::int32_t gap = get_natural(reader, models.gap);
    if (gap >= words - next) return "words";
    const std::int32_t more = get_natural(reader, models.count);
    if (more >= most - sum) return "counts";
    read.words.push_back(next + gap);
    read.counts.push_back(1 + more);
    next += gap + 1;
    sum += 1 + more;
  }
  if (!reader.ended_well()) return "code";
  counts = std::move(read);
  return nullptr;
}

}  // namespace covey::place
