// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lcd/lcd_log.h"

#include <spdlog/spdlog.h>

#include <optional>
#include <string>
#include <variant>

#include "core/base/error.h"
#include "procs/common/channels.h"

namespace covey {
namespace {

template <typename T>
std::optional<place::LcdRecord> record_of(const Bytes& bytes) {
  T message{};
  if (!decode(bytes, message)) return std::nullopt;
  return message;
}

std::optional<place::LcdRecord> record_from(const std::string& channel, const Bytes& bytes) {
  if (channel == kLcdBag.out().name || channel == kLcdBag.in().name) return record_of<lcd_bag_t>(bytes);
  if (channel == kLcdFrame.out().name) return record_of<lcd_frame_t>(bytes);
  if (channel == kLcdLoop.in().name) return record_of<lcd_loop_t>(bytes);
  if (channel == kLoop.name) return record_of<loop_t>(bytes);
  return std::nullopt;
}

const char* channel_of(const place::LcdRecord& record, int robot) {
  if (const auto* bag = std::get_if<lcd_bag_t>(&record)) {
    return bag->from == robot ? kLcdBag.out().name : kLcdBag.in().name;
  }
  if (std::holds_alternative<lcd_frame_t>(record)) return kLcdFrame.out().name;
  if (std::holds_alternative<lcd_loop_t>(record)) return kLcdLoop.in().name;
  return kLoop.name;
}

using Handler = std::function<void(const place::LcdRecord& record, Utime utime)>;

void read(const std::filesystem::path& file, const Handler& take) {
  if (!std::filesystem::exists(file)) return;
  try {
    Utime utime = 0;
    LogReader reader(file.string(), [&](const std::string& channel, const Bytes& bytes) {
      if (const auto record = record_from(channel, bytes)) take(*record, utime);
    });
    while (const auto next = reader.next_time()) {
      utime = *next;
      reader.deliver();
    }
  } catch (const InputError& error) {
    spdlog::warn("{}: nothing can be read back, starting without", error.what());
  }
}

}  // namespace

LcdLog::LcdLog(int robot, const std::filesystem::path& folder,
               const std::function<void(const place::LcdRecord&)>& take)
    : robot_(robot) {
  // Rewritten on each start, so that a cut-off end is not followed by good events.
  const std::filesystem::path file = folder / "lcd.lcm";
  const std::filesystem::path fresh = folder / "lcd.lcm.new";
  log_ = std::make_unique<LogRecorder>(fresh.string());
  read(file, [&](const place::LcdRecord& record, Utime utime) {
    write(record, utime);
    take(record);
  });
  log_->flush();
  std::filesystem::rename(fresh, file);
}

void LcdLog::append(const place::LcdRecord& record, Utime now) {
  write(record, now);
  log_->flush();
}

void LcdLog::write(const place::LcdRecord& record, Utime now) {
  std::visit([&](const auto& message) { log_->write(now, channel_of(record, robot_), encode(message)); },
             record);
}

}  // namespace covey
