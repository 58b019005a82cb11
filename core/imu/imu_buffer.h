// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The last samples of an IMU, in order of time, and any stretch of them with interpolated ends.

#include <deque>
#include <vector>

#include "core/imu/state.h"

namespace covey {

class ImuBuffer {
 public:
  // The oldest sample goes when there are more than `capacity`.
  explicit ImuBuffer(std::size_t capacity = 20'000) : capacity_(capacity) {}

  // Why a sample is not taken ("not_finite", "late"), or null.
  const char* refuse(const ImuSample& sample) const;
  const char* add(const ImuSample& sample);

  bool empty() const { return samples_.empty(); }
  std::size_t size() const { return samples_.size(); }
  // Of a buffer that is not empty.
  const ImuSample& front() const { return samples_.front(); }
  const ImuSample& back() const { return samples_.back(); }

  bool covers(Utime from, Utime until) const {
    return !empty() && from <= until && front().utime <= from && until <= back().utime;
  }
  // The samples within [from, until], beginning with one at `from` and ending with one at `until` (linear interpolation where there is none).
  // Empty where the buffer does not cover that.
  std::vector<ImuSample> between(Utime from, Utime until) const;

  void drop_before(Utime utime);  // keeps the last sample at or before utime, for interpolation
  void clear() { samples_.clear(); }

 private:
  ImuSample at(const std::deque<ImuSample>::const_iterator& after, Utime utime) const;

  std::size_t capacity_;
  std::deque<ImuSample> samples_;
};

// The longest step between two samples.
Utime longest_gap(const std::vector<ImuSample>& samples);

}  // namespace covey
