// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/bands.h"

#include <algorithm>
#include <limits>

namespace covey {

std::vector<band_t> split_bands(const Bytes& message, Utime utime, std::int64_t run, std::int32_t number) {
  const auto total = static_cast<std::int32_t>(message.size());
  const std::int32_t bands = std::max(1, (total + kBandBytes - 1) / kBandBytes);
  std::vector<band_t> result(static_cast<std::size_t>(bands));
  for (std::int32_t i = 0; i < bands; ++i) {
    band_t& band = result[static_cast<std::size_t>(i)];
    band.utime = utime;
    band.run = run;
    band.number = number;
    band.band = static_cast<std::int16_t>(i);
    band.bands = static_cast<std::int16_t>(bands);
    band.total_bytes = total;
    const auto begin = message.begin() + std::int64_t{i} * kBandBytes;
    band.data.assign(begin, begin + std::min(kBandBytes, total - i * kBandBytes));
    band.n = static_cast<std::int32_t>(band.data.size());
  }
  return result;
}

BandAssembler::Result BandAssembler::add(band_t band) {
  Result result;
  const std::int32_t total = std::clamp(band.total_bytes, 0, kMostBytes);
  const std::int32_t bands = std::max(1, (total + kBandBytes - 1) / kBandBytes);
  if (band.total_bytes != total || band.bands != bands || band.band < 0 || band.band >= bands ||
      band.number < 0 || band.number == std::numeric_limits<std::int32_t>::max() ||
      band.n != std::min(kBandBytes, band.total_bytes - band.band * kBandBytes)) {
    result.dropped = "impossible";
    return result;
  }
  if (started_ && band.run < run_) {
    result.dropped = "old";
    return result;
  }
  if (!started_ || band.run > run_) {
    partial_.clear();
    run_ = band.run;
    next_ = band.number;  // whoever comes late has not lost what was before
    started_ = true;
  }
  if (band.number < next_) {
    result.dropped = "old";
    return result;
  }
  Partial& partial = partial_[band.number];
  if (partial.have.empty()) {
    partial.bytes.resize(static_cast<std::size_t>(band.total_bytes));
    partial.have.resize(static_cast<std::size_t>(bands));
    partial.left = bands;
  } else if (partial.bytes.size() != static_cast<std::size_t>(band.total_bytes)) {
    result.dropped = "impossible";
    return result;
  }
  if (partial.have[static_cast<std::size_t>(band.band)]) {
    result.dropped = "duplicate";
    return result;
  }
  partial.have[static_cast<std::size_t>(band.band)] = true;
  std::copy(band.data.begin(), band.data.end(), partial.bytes.begin() + std::int64_t{band.band} * kBandBytes);
  if (--partial.left == 0) {
    Bytes message = std::move(partial.bytes);
    partial_.erase(band.number);
    give_up_before(band.number, result);
    next_ = band.number + 1;
    result.message = std::move(message);
  } else if (partial_.size() > kMostPartial) {
    const std::int32_t oldest = partial_.begin()->first;
    give_up_before(oldest + 1, result);
    next_ = oldest + 1;
  }
  return result;
}

void BandAssembler::give_up_before(std::int32_t number, Result& result) {
  int given_up = 0;
  while (!partial_.empty() && partial_.begin()->first < number) {
    partial_.erase(partial_.begin());
    ++given_up;
  }
  result.incomplete += given_up;
  result.missing += number - next_ - given_up;
}

}  // namespace covey
