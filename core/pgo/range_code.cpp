// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/range_code.h"

#include <bit>
#include <cstdlib>
#include <utility>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

constexpr std::uint32_t kSmallestRange = 1U << 24U;
constexpr std::uint16_t kMemory =
    400;  // of a model, in halves of bits: what it has seen counts half from then on

std::uint32_t share_of_zeros(std::uint32_t range, const BitModel& model) {
  return range / model.all() * model.zeros();
}

}  // namespace

void BitModel::learn(bool bit) {
  if (!bit) zeros_ += 2;
  all_ += 2;
  if (all_ <= kMemory) return;
  const auto ones = static_cast<std::uint16_t>((all_ - zeros_ + 1) / 2);
  zeros_ = static_cast<std::uint16_t>((zeros_ + 1) / 2);
  all_ = static_cast<std::uint16_t>(zeros_ + ones);
}

void RangeWriter::put(bool bit, BitModel& model) {
  const std::uint32_t zeros = share_of_zeros(range_, model);
  if (bit) {
    raise_low(zeros);
    range_ -= zeros;
  } else {
    range_ = zeros;
  }
  model.learn(bit);
  shift();
}

void RangeWriter::put(std::int32_t number, NumberModel& model) {
  COVEY_CHECK(number <= kLargestCoded && number >= -kLargestCoded);
  const auto magnitude = static_cast<std::uint32_t>(std::abs(number));
  const int digits = std::bit_width(magnitude);
  for (int k = 0; k < kMostDigits && k <= digits; ++k) put(digits > k, model.more[k]);
  if (digits == 0) return;
  put_plain(magnitude & ((1U << (digits - 1)) - 1), digits - 1);
  put_plain(number < 0 ? 1 : 0, 1);
}

void RangeWriter::put_plain(std::uint32_t digits, int count) {
  for (int k = count - 1; k >= 0; --k) {
    range_ /= 2;
    if (((digits >> k) & 1U) != 0) raise_low(range_);
    shift();
  }
}

// What carries over goes into the bytes that are written already.
void RangeWriter::raise_low(std::uint32_t by) {
  low_ += by;
  if (low_ >= by) return;
  for (auto byte = bytes_.rbegin(); byte != bytes_.rend() && ++*byte == 0; ++byte) {
  }
}

void RangeWriter::shift() {
  for (; range_ < kSmallestRange; range_ <<= 8U, low_ <<= 8U)
    bytes_.push_back(static_cast<std::uint8_t>(low_ >> 24U));
}

// The interval is wide enough for a number whose last three bytes are zero, which need not be written.
std::vector<std::uint8_t> RangeWriter::finish() {
  raise_low(-low_ & (kSmallestRange - 1));
  bytes_.push_back(static_cast<std::uint8_t>(low_ >> 24U));
  return std::move(bytes_);
}

RangeReader::RangeReader(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {
  for (; position_ < 4; ++position_)
    offset_ = offset_ << 8U | (position_ < bytes_.size() ? bytes_[position_] : 0);
}

bool RangeReader::get(BitModel& model) {
  const std::uint32_t zeros = share_of_zeros(range_, model);
  const bool bit = offset_ >= zeros;
  if (bit) {
    offset_ -= zeros;
    range_ -= zeros;
  } else {
    range_ = zeros;
  }
  model.learn(bit);
  shift();
  return bit;
}

std::int32_t RangeReader::get(NumberModel& model) {
  int digits = 0;
  while (digits < kMostDigits && get(model.more[digits])) ++digits;
  if (digits == 0) return 0;
  const auto magnitude = static_cast<std::int32_t>(1U << (digits - 1) | get_plain(digits - 1));
  return get_plain(1) == 1 ? -magnitude : magnitude;
}

std::uint32_t RangeReader::get_plain(int count) {
  std::uint32_t digits = 0;
  for (int k = 0; k < count; ++k) {
    range_ /= 2;
    const bool bit = offset_ >= range_;
    if (bit) offset_ -= range_;
    digits = digits << 1U | (bit ? 1U : 0U);
    shift();
  }
  return digits;
}

void RangeReader::shift() {
  for (; range_ < kSmallestRange; range_ <<= 8U, ++position_)
    offset_ = offset_ << 8U | (position_ < bytes_.size() ? bytes_[position_] : 0);
}

// It is four bytes ahead of the writer, who writes one when it finishes.
bool RangeReader::ended_well() const { return bytes_.size() + 3 == position_; }

}  // namespace covey::pgo
