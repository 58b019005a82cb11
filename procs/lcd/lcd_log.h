// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What an lcd must not lose with its process, under --state: lcd.lcm, an LCM log that grows. OUT_LCD_BAG and OUT_LCD_FRAME (with all
// features) of the own keyframes, IN_LCD_BAG of the others', LOOP, and IN_LCD_LOOP where the other robot said that it has a closure.
// It is read back at the start; one whose end was cut off, or is not what it should be, is good up to there.

#include <filesystem>
#include <functional>
#include <memory>

#include "core/place/lcd_agent.h"
#include "procs/common/log_file.h"

namespace covey {

class LcdLog {
 public:
  // Calls `take` for everything that was kept, in its order, and leaves the log open for more. Throws InputError where the folder
  // cannot be written.
  LcdLog(int robot, const std::filesystem::path& folder,
         const std::function<void(const place::LcdRecord&)>& take);

  // On disk when it returns.
  void append(const place::LcdRecord& record, Utime now);

 private:
  void write(const place::LcdRecord& record, Utime now);

  int robot_;
  std::unique_ptr<LogRecorder> log_;
};

}  // namespace covey
