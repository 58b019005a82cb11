// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/bit_code.h"

#include <algorithm>
#include <limits>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

constexpr std::uint32_t kLongest = 24;  // ones; that many say that the number follows as it is
constexpr int kPlainBits = 21;

std::uint32_t folded(std::int32_t number) {
  return number < 0 ? 2 * static_cast<std::uint32_t>(-number) - 1 : 2 * static_cast<std::uint32_t>(number);
}
std::int32_t unfolded(std::uint32_t u) {
  return u % 2 == 1 ? -static_cast<std::int32_t>((u + 1) / 2) : static_cast<std::int32_t>(u / 2);
}

}  // namespace

void BitWriter::put(std::uint32_t value, int bits) {
  for (int bit = bits - 1; bit >= 0; --bit) {
    if (free_ == 0) {
      bytes_.push_back(0);
      free_ = 8;
    }
    bytes_.back() |= static_cast<std::uint8_t>(((value >> bit) & 1U) << --free_);
  }
}

void BitWriter::put_rice(std::int32_t number, int k) {
  COVEY_CHECK(number <= kLargestCoded && number >= -kLargestCoded);
  const std::uint32_t u = folded(number);
  const std::uint32_t ones = std::min(u >> k, kLongest);
  for (std::uint32_t i = 0; i < ones; ++i) put(1, 1);
  if (ones == kLongest) {
    put(u, kPlainBits);
  } else {
    put(0, 1);
    put(u & ((1U << k) - 1), k);
  }
}

std::uint32_t BitReader::get(int bits) {
  std::uint32_t value = 0;
  for (int bit = 0; bit < bits; ++bit, ++position_) {
    value <<= 1;
    if (position_ / 8 >= bytes_.size()) {
      good_ = false;
    } else {
      value |= (bytes_[position_ / 8] >> (7 - position_ % 8)) & 1U;
    }
  }
  return value;
}

std::int32_t BitReader::get_rice(int k) {
  std::uint32_t ones = 0;
  while (ones < kLongest && get(1) == 1) ++ones;
  const std::uint32_t u = ones == kLongest ? get(kPlainBits) : (ones << k) | get(k);
  if (u > folded(kLargestCoded)) good_ = false;
  return unfolded(u);
}

int best_rice(const std::vector<std::int32_t>& numbers) {
  int best = 0;
  std::uint64_t fewest = std::numeric_limits<std::uint64_t>::max();
  for (int k = 0; k <= kLargestRice; ++k) {
    std::uint64_t bits = 0;
    for (const std::int32_t number : numbers) {
      const std::uint32_t ones = folded(number) >> k;
      bits += ones >= kLongest ? kLongest + kPlainBits : ones + 1 + static_cast<std::uint32_t>(k);
    }
    if (bits >= fewest) continue;
    fewest = bits;
    best = k;
  }
  return best;
}

}  // namespace covey::pgo
