// SPDX-License-Identifier: BSD-3-Clause
#include "core/imu/imu_buffer.h"

#include <algorithm>

namespace covey {
namespace {

bool earlier(const ImuSample& sample, Utime utime) { return sample.utime < utime; }

}  // namespace

const char* ImuBuffer::refuse(const ImuSample& sample) const {
  if (!sample.gyro.allFinite() || !sample.accel.allFinite()) return "not_finite";
  if (!empty() && sample.utime <= back().utime) return "late";
  return nullptr;
}

const char* ImuBuffer::add(const ImuSample& sample) {
  if (const char* reason = refuse(sample)) return reason;
  samples_.push_back(sample);
  if (samples_.size() > capacity_) samples_.pop_front();
  return nullptr;
}

// The sample at utime, from the first one that is not earlier and the one before it.
ImuSample ImuBuffer::at(const std::deque<ImuSample>::const_iterator& after, Utime utime) const {
  if (after->utime == utime) return *after;
  const ImuSample& before = *std::prev(after);
  const double s =
      static_cast<double>(utime - before.utime) / static_cast<double>(after->utime - before.utime);
  return {utime, before.gyro + s * (after->gyro - before.gyro),
          before.accel + s * (after->accel - before.accel), before.measured && after->measured};
}

std::vector<ImuSample> ImuBuffer::between(Utime from, Utime until) const {
  std::vector<ImuSample> samples;
  if (!covers(from, until)) return samples;
  auto next = std::lower_bound(samples_.begin(), samples_.end(), from, earlier);
  samples.push_back(at(next, from));
  while (next->utime < until) {
    if (next->utime > from) samples.push_back(*next);
    ++next;
  }
  if (until > from) samples.push_back(at(next, until));
  return samples;
}

void ImuBuffer::drop_before(Utime utime) {
  while (samples_.size() > 1 && samples_[1].utime <= utime) samples_.pop_front();
}

Utime longest_gap(const std::vector<ImuSample>& samples) {
  Utime longest = 0;
  for (std::size_t k = 1; k < samples.size(); ++k)
    longest = std::max(longest, samples[k].utime - samples[k - 1].utime);
  return longest;
}

}  // namespace covey
