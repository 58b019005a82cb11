// SPDX-License-Identifier: BSD-3-Clause
#include "procs/common/log_file.h"

#include <spdlog/spdlog.h>

#include <cstdio>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "core/base/error.h"

namespace covey {
namespace {

constexpr Utime kLastUtime = 10'000'000'000'000'000;  // in the year 2286; virtual time must not overflow

}  // namespace

LogReader::LogReader(const std::string& file, Handler handler) : file_(file), handler_(std::move(handler)) {
  if (!std::filesystem::is_regular_file(file)) throw_input_error("{}: no such log file", file);
  log_ = std::make_unique<lcm::LogFile>(file, "r");
  if (!log_->good()) throw_input_error("{}: cannot be read", file);
  advance();
  if (!time_ && std::filesystem::file_size(file) > 0) throw_input_error("{}: is not an LCM log", file);
}

LogReader::~LogReader() = default;

std::optional<Utime> LogReader::next_time() { return time_; }

void LogReader::deliver() {
  const std::string channel = std::move(channel_);
  const Bytes bytes = std::move(bytes_);
  advance();
  handler_(channel, bytes);
}

void LogReader::advance() {
  // A logger that was killed and then appended leaves half an event in the middle: liblcm gives up there, and finds the
  // next event when it is asked again.
  const lcm::LogEvent* event = log_->readNextEvent();
  while (event == nullptr ? !at_end() : event->timestamp < 0 || event->timestamp > kLastUtime) {
    if (!std::exchange(said_damaged_, true)) {
      spdlog::warn("{}: what is no event, or at no possible time, is left out", file_);
    }
    event = log_->readNextEvent();
  }
  if (event == nullptr) {
    time_.reset();
    return;
  }
  const auto* data = static_cast<const std::uint8_t*>(event->data);
  time_ = event->timestamp;
  channel_ = event->channel;
  bytes_.assign(data, data + event->datalen);
}

bool LogReader::at_end() const {
  return std::feof(log_->getFilePtr()) != 0 || std::ferror(log_->getFilePtr()) != 0;
}

LogRecorder::LogRecorder(const std::string& file) : log_(std::make_unique<lcm::LogFile>(file, "w")) {
  if (!log_->good()) throw_input_error("{}: cannot be written", file);
}

LogRecorder::~LogRecorder() = default;

void LogRecorder::write(Utime time, const std::string& channel, const Bytes& bytes) {
  lcm::LogEvent event{};
  event.timestamp = time;
  event.channel = channel;
  event.datalen = static_cast<std::int32_t>(bytes.size());
  event.data = const_cast<std::uint8_t*>(bytes.data());  // lcm's struct serves reading too
  if (log_->writeEvent(&event) != 0) good_ = false;
}

void LogRecorder::flush() {
  if (std::fflush(log_->getFilePtr()) != 0) good_ = false;
}

}  // namespace covey
