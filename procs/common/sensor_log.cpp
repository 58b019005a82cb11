// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/sensor_log.h"

#include <limits>

#include "core/base/bands.h"

namespace covey {

void SensorLogWriter::put(Utime utime, const std::string& channel, Bytes bytes) {
  waiting_.emplace(utime, std::pair(channel, std::move(bytes)));
}

void SensorLogWriter::put_bands(Utime utime, const std::string& channel, const Bytes& bytes) {
  BandNumbers& numbers = numbers_.try_emplace(channel, BandNumbers{utime, 0}).first->second;
  Utime due = utime;
  for (const band_t& band : split_bands(bytes, utime, numbers.run, numbers.next)) {
    put(due, channel, encode(band));
    due += kBandSpacingUs;
  }
  ++numbers.next;
}

void SensorLogWriter::write_until(Utime utime) {
  const auto end = waiting_.upper_bound(utime);
  for (auto event = waiting_.begin(); event != end; ++event) {
    log_.write(event->first, event->second.first, event->second.second);
  }
  waiting_.erase(waiting_.begin(), end);
}

bool SensorLogWriter::finish() {
  write_until(std::numeric_limits<Utime>::max());
  log_.flush();
  return log_.good();
}

}  // namespace covey
