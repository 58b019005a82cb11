// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A run's sensors as an LCM log, as a recording of their bus would have it: messages at their utime, the bands of image sets from there on, kBandSpacingUs
// apart, all in order of time. The same messages give the same bytes.

#include <map>
#include <string>
#include <utility>

#include "core/base/bytes.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"

namespace covey {

class SensorLogWriter {
 public:
  explicit SensorLogWriter(const std::string& file) : log_(file) {}

  // utime must not fall from call to call, whatever the channel.
  template <typename T>
  void write(const Channel<T>& channel, const T& message) {
    put(message.utime, channel.name, encode(message));
    write_until(message.utime);
  }
  template <typename T>
  void write(const StreamChannel<T>& channel, const T& message) {
    put(message.utime, channel.name, encode(message));
    write_until(message.utime);
  }
  template <typename T>
  void write(const BandedChannel<T>& channel, const T& message) {
    put_bands(message.utime, channel.name, encode(message));
    write_until(message.utime);
  }

  // What is left; false where something could not be written, as on a full disk.
  bool finish();

 private:
  void put(Utime utime, const std::string& channel, Bytes bytes);
  void put_bands(Utime utime, const std::string& channel, const Bytes& bytes);
  void write_until(Utime utime);

  struct BandNumbers {
    Utime run = 0;
    std::int32_t next = 0;
  };

  LogRecorder log_;
  std::multimap<Utime, std::pair<std::string, Bytes>> waiting_;  // bands that are due after a message to come
  std::map<std::string, BandNumbers> numbers_;
};

}  // namespace covey
